#include "schemes/explicit_scheme.h"

#include "effects/effect.h"
#include "schemes/step_system.h"

namespace mass_spring {

ExplicitScheme::ExplicitScheme(Workspace& workspace, Scheme scheme)
    : workspace_(workspace),
      scheme_(scheme),
      accelerations_(3, workspace.model().particleCount()),
      mobilities_(3, workspace.model().particleCount()) {
  if (scheme == Scheme::kExplicitEuler) return;
  for (Vectors* vectors : {&x_, &v_, &sum_x_, &sum_v_, &last_v_}) {
    vectors->setZero(3, workspace.model().particleCount());
  }
}

SubstepReport ExplicitScheme::advance(double h, const Drive& drive, State& state) {
  SubstepReport report;
  beginSubstep(drive, state);
  if (scheme_ == Scheme::kRk4) {
    advanceRungeKutta(h, drive, state, report);
  } else {
    advanceEuler(h, drive, state);
  }
  return report;
}

void ExplicitScheme::beginSubstep(const Drive& drive, const State& state) {
  if (pinned_ != drive.pinned) {
    pinned_ = drive.pinned;
    pins_.clear();
    for (Eigen::Index i = 0; i < mobilities_.cols(); ++i) {
      const double mass = workspace_.model().masses[i];
      mobilities_.col(i).setConstant(drive.isPinned(i) ? 0.0 : 1.0 / mass);
      if (drive.isPinned(i)) pins_.push_back({i, state.velocities.col(i), state.velocities.col(i)});
    }
  }
  for (PinnedParticle& pin : pins_) {
    pin.before = pin.now;
    pin.now = state.velocities.col(pin.particle);
  }
}

void ExplicitScheme::findAccelerations(const Drive& drive, const Point& point, double share) {
  sumForces(workspace_, drive.loads, point, accelerations_);
  addPinWork(drive, share, scheme_ != Scheme::kRk4);
  accelerations_.array() *= mobilities_.array();
  clearPinned(drive, accelerations_);  // 0 times infinity
}

void ExplicitScheme::addPinWork(const Drive& drive, double share, bool euler) {
  for (const PinnedParticle& pin : pins_) {
    // Euler's schemes have the forces at the start of a sub-step only. These act for half of it,
    // and for half of the one before, so that the work is right to second order.
    const Eigen::Vector3d speed = euler ? Eigen::Vector3d(0.5 * (pin.before + pin.now)) : pin.now;
    if (speed.isZero(0.0)) continue;
    Eigen::Vector3d force = accelerations_.col(pin.particle);
    if (drive.loads) force -= drive.loads->col(pin.particle);
    pin_work_ -= share * force.dot(speed);
  }
}

void ExplicitScheme::advanceEuler(double h, const Drive& drive, State& state) {
  findAccelerations(drive, drive.point(state.positions, state.velocities, 0.0), h);
  if (scheme_ == Scheme::kExplicitEuler) state.positions += h * state.velocities;
  state.velocities += h * accelerations_;
  if (scheme_ == Scheme::kSymplecticEuler) state.positions += h * state.velocities;
}

void ExplicitScheme::advanceRungeKutta(double h, const Drive& drive, State& state,
                                       SubstepReport& report) {
  static constexpr double kAt[4] = {0.0, 0.5, 0.5, 1.0};
  static constexpr double kAhead[4] = {0.5, 0.5, 1.0, 0.0};  // where the next stage lies
  static constexpr double kWeight[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
  x_ = state.positions;
  v_ = state.velocities;
  sum_x_ = state.positions;
  sum_v_ = state.velocities;
  for (int stage = 0; stage < 4; ++stage) {
    findAccelerations(drive, drive.point(x_, v_, kAt[stage] * h), h * kWeight[stage]);
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

SubstepReport ExplicitScheme::advanceVerlet(int substeps, double h, const Drive& drive,
                                            State& state) {
  beginSubstep(drive, state);
  const double substep = h / substeps;
  // Velocities are known half a sub-step off the positions. Spring damping wants them where the
  // positions are: they are continued with the last acceleration, which keeps the order.
  const auto kick = [&](int n, double share, double ahead) {
    sumForces(workspace_, drive.loads, drive.point(state.positions, v_, n * substep),
              accelerations_);
    addPinWork(drive, share * substep, false);
    double *const v = state.velocities.data(), *const x = state.positions.data();
    double* const expected = v_.data();
    for (Eigen::Index i = 0; i < accelerations_.size(); ++i) {
      const double mobility = mobilities_.data()[i];
      // Forces on pinned particles may be infinite.
      const double change = mobility > 0.0 ? substep * mobility * accelerations_.data()[i] : 0.0;
      v[i] += share * change;
      x[i] += ahead * v[i];
      expected[i] = v[i] + 0.5 * change;
    }
  };
  sum_v_ = v_ = state.velocities;
  kick(0, 0.5, substep);
  // The velocities in the middle, or half a sub-step later.
  const int half = substeps / 2;
  if (half == 0) last_v_ = state.velocities;
  for (int n = 1; n < substeps; ++n) {
    kick(n, 1.0, substep);
    if (n == half) last_v_ = state.velocities;
  }
  kick(substeps, 0.5, 0.0);
  // Verlet misses substep^3 / 6 times the jerk in each sub-step. The jerk comes from the mean
  // accelerations of the two halves of the step, h / 2 apart: of motions much faster than the step,
  // which are stable and lose no more than their phase, the means keep little.
  const double first = (half + 0.5) * substep, second = h - first;
  x_ = (substep * substep / 3.0) *
       ((state.velocities - last_v_) / second - (last_v_ - sum_v_) / first);
  SubstepReport report;
  report.estimated_error = rootMeanSquare(drive, x_);
  return report;
}

}  // namespace mass_spring
