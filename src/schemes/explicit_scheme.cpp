#include "schemes/explicit_scheme.h"

#include "effects/effect.h"
#include "schemes/step_system.h"

namespace mass_spring {

ExplicitScheme::ExplicitScheme(const Model& model, Scheme scheme)
    : model_(model),
      scheme_(scheme),
      accelerations_(3, model.particleCount()),
      mobilities_(3, model.particleCount()) {
  if (scheme != Scheme::kRk4) return;
  for (Vectors* vectors : {&x_, &v_, &sum_x_, &sum_v_, &last_v_}) {
    vectors->setZero(3, model.particleCount());
  }
}

SubstepReport ExplicitScheme::advance(double h, const Drive& drive, State& state) {
  SubstepReport report;
  findMobilities(drive);
  if (scheme_ == Scheme::kRk4) {
    advanceRungeKutta(h, drive, state, report);
  } else {
    advanceEuler(h, drive, state);
  }
  return report;
}

void ExplicitScheme::findMobilities(const Drive& drive) {
  for (Eigen::Index i = 0; i < mobilities_.cols(); ++i) {
    mobilities_.col(i).setConstant(drive.isPinned(i) ? 0.0 : 1.0 / model_.masses[i]);
  }
}

void ExplicitScheme::findAccelerations(const Drive& drive, const Vectors& positions,
                                       const Vectors& velocities) {
  sumForces(model_, drive.loads, positions, velocities, accelerations_);
  accelerations_.array() *= mobilities_.array();
  clearPinned(drive, accelerations_);  // 0 times infinity
}

void ExplicitScheme::advanceEuler(double h, const Drive& drive, State& state) {
  findAccelerations(drive, state.positions, state.velocities);
  if (scheme_ == Scheme::kExplicitEuler) state.positions += h * state.velocities;
  state.velocities += h * accelerations_;
  if (scheme_ == Scheme::kSymplecticEuler) state.positions += h * state.velocities;
}

void ExplicitScheme::advanceRungeKutta(double h, const Drive& drive, State& state,
                                       SubstepReport& report) {
  static constexpr double kAhead[4] = {0.5, 0.5, 1.0, 0.0};  // where the next stage lies
  static constexpr double kWeight[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
  x_ = state.positions;
  v_ = state.velocities;
  sum_x_ = state.positions;
  sum_v_ = state.velocities;
  for (int stage = 0; stage < 4; ++stage) {
    findAccelerations(drive, x_, v_);
    sum_x_ += h * kWeight[stage] * v_;
    sum_v_ += h * kWeight[stage] * accelerations_;
    if (stage == 3) break;
    x_ = state.positions + h * kAhead[stage] * v_;
    v_ = state.velocities + h * kAhead[stage] * accelerations_;
  }
  state.positions = sum_x_;
  state.velocities = sum_v_;
  // With the derivative at the end in place of a part of the last stage's there is a formula of
  // order 3; their difference costs no evaluation, as positions only need the velocities.
  last_v_ = (h / 6.0) * (v_ - state.velocities);
  report.estimated_error = rootMeanSquare(drive, last_v_);
}

}  // namespace mass_spring
