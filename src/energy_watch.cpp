#include "energy_watch.h"

#include <algorithm>
#include <cmath>

#include "effects/effect.h"

namespace mass_spring {
namespace {

// Of the energies that take part: so much more than was given, and it has more than doubled. The
// energy of symplectic Euler, with velocities and positions at the same time, swings by
// 1 / (1 - (w h / 2)^2) in a motion of w [rad/s] (Hairer, Lubich and Wanner, "Geometric numerical
// integration", 2006, IX.3). It doubles at 0.7 of the largest stable sub-step. No motion that is
// resolved comes near that.
constexpr double kShare = 0.5;
// Energies are compared after that many evaluations of the forces. A comparison costs about two of
// them, so that a step becomes no more than 1 % dearer.
constexpr int kEvaluations = 250;
// What moved long ago is no measure for what moves now.
constexpr double kMemory = 0.9;

/// Symplectic Euler's velocities are those of half a sub-step before, explicit Euler's those of
/// half a sub-step after: the force that led to them was that of the positions before.
double velocityShift(Scheme scheme, const SolverOptions& options) {
  if (scheme == Scheme::kExplicitEuler) return -0.5;
  return scheme == Scheme::kSymplecticEuler && !options.accuracy ? 0.5 : 0.0;
}

}  // namespace

EnergyWatch::EnergyWatch(Workspace& workspace, Scheme scheme)
    : workspace_(workspace),
      rounding_(workspace.model()),
      shift_(velocityShift(scheme, workspace.model().solver)) {
  const Model& model = workspace.model();
  for (Vectors* vectors : {&free_masses_, &velocities_, &scratch_}) {
    vectors->setZero(3, model.particleCount());
  }
  setPinned(std::vector<char>(static_cast<std::size_t>(model.particleCount()), 0));
  vouched_ = balance_;  // steps allocate nothing
}

double EnergyWatch::kineticEnergy(const Vectors& velocities) const {
  return 0.5 * free_masses_.cwiseProduct(velocities.cwiseAbs2()).sum();
}

Energy EnergyWatch::energy(const Point& point) {
  Energy energy;
  energy.kinetic = kineticEnergy(point.velocities);
  addEnergy(workspace_, point, nullptr, energy);
  return energy;
}

void EnergyWatch::begin(const State& before, const Drive& drive) {
  if (balance_.pinned != drive.pinned) {
    // The kinetic energy of a particle that is pinned from now on leaves; or it comes back.
    balance_.given -= kineticEnergy(before.velocities);
    setPinned(drive.pinned);
    balance_.given += kineticEnergy(before.velocities);
  }
  if (balance_.known) return;
  const Point point = drive.point(before.positions, before.velocities, 0.0);
  const Energy start = energy(point);
  balance_.known = true;
  balance_.steps_above = balance_.evaluations = 0;
  balance_.given = start.total();
  balance_.gravity = start.gravity;
  balance_.motion = start.kinetic + start.elastic;
  balance_.power = powerOfEffects(workspace_, point);
}

void EnergyWatch::setPinned(const std::vector<char>& pinned) {
  balance_.pinned = pinned;
  for (std::size_t i = 0; i < pinned.size(); ++i) {
    const auto particle = static_cast<Eigen::Index>(i);
    free_masses_.col(particle).setConstant(pinned[i] ? 0.0 : workspace_.model().masses[particle]);
  }
}

void EnergyWatch::addWork(const Step& step, const State& before, const State& end,
                          const Drive& drive) {
  balance_.given += step.pin_work;
  double fed = fedByTime(workspace_, drive.point(before.positions, before.velocities, 0.0), step.h);
  const double power =
      powerOfEffects(workspace_, drive.point(end.positions, end.velocities, step.h));
  if (power > 0.0 || balance_.power > 0.0) {
    // What swings within the step ends at any velocity: the way that it has come tells more.
    scratch_ = (end.positions - before.positions) / step.h;
    const double on_the_way =
        powerOfEffects(workspace_, drive.point(end.positions, scratch_, step.h));
    fed = std::max(fed, step.h * std::max({power, balance_.power, on_the_way}));
  }
  balance_.power = power;
  balance_.given += std::max(fed, 0.0);
  if (drive.loads == nullptr) return;
  // Explicit Euler moves only after it has got faster: a force that acts for one step works on no
  // way at all, but changes velocities.
  double along_way = 0.0, by_speed = 0.0;
  for (Eigen::Index i = 0; i < end.positions.cols(); ++i) {
    if (drive.isPinned(i)) continue;
    const auto load = drive.loads->col(i);
    along_way += load.dot(end.positions.col(i) - before.positions.col(i));
    by_speed += 0.5 * step.h * load.dot(before.velocities.col(i) + end.velocities.col(i));
  }
  balance_.given += std::max(along_way, by_speed);
}

void EnergyWatch::compare(const Step& step, const State& end, const Drive& drive) {
  const Vectors* velocities = &end.velocities;
  if (shift_ != 0.0) {
    // Without the loads, which may end with this step: addWork() has their part.
    sumForces(workspace_, nullptr, drive.point(end.positions, end.velocities, step.h), scratch_);
    for (Eigen::Index i = 0; i < scratch_.cols(); ++i) {
      velocities_.col(i) = end.velocities.col(i);
      if (drive.isPinned(i)) continue;
      velocities_.col(i) += shift_ * step.substep / workspace_.model().masses[i] * scratch_.col(i);
    }
    velocities = &velocities_;
  }
  const Energy now = energy(drive.point(end.positions, *velocities, step.h));
  const double motion = now.kinetic + now.elastic + std::abs(now.gravity - balance_.gravity);
  const double noise =
      rounding_.energy(end.positions, step.substep, motion + std::abs(now.gravity));
  balance_.evaluations = 0;
  vouches_ = now.total() - balance_.given <= kShare * std::max(motion, balance_.motion) + noise;
  balance_.steps_above = vouches_ ? 0 : balance_.steps_above + 1;
  if (!vouches_) return;
  balance_.motion = std::max(motion, kMemory * balance_.motion);
  if (now.total() < balance_.given) {
    balance_.given = now.total();
    balance_.gravity = now.gravity;
  }
  vouched_ = balance_;
}

void EnergyWatch::observe(const Step& step, const State& before, const State& end,
                          const Drive& drive) {
  begin(before, drive);
  addWork(step, before, end, drive);
  balance_.evaluations += step.evaluations;
  vouches_ = false;
  if (balance_.steps_above > 0 || balance_.evaluations >= kEvaluations ||
      !(kineticEnergy(end.velocities) <= balance_.motion)) {
    compare(step, end, drive);
  }
}

void EnergyWatch::restart() { balance_.known = vouched_.known = false; }

void EnergyWatch::goBack() {
  balance_ = vouched_;
  setPinned(balance_.pinned);
}

void EnergyWatch::continueFrom(const EnergyWatch& other) {
  balance_ = other.balance_;
  vouched_ = other.vouched_;
  free_masses_ = other.free_masses_;
}

}  // namespace mass_spring
