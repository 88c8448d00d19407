#include "energy_check.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "effects/springs.h"

namespace mass_spring {
namespace {

// Shares of the energies that take part, in one step and in all.
constexpr double kStepTolerance = 1e-3;
constexpr double kTotalTolerance = 1e-4;
// In all, where there is no limit for each step. A swing at a frequency w that tr_bdf2 resolves is
// off by some 0.04 (h w)^3 of its energy in between: 3e-4 at 30 steps per period.
constexpr double kSwingTolerance = 5e-4;
// A step in which gravity gives or takes a larger share of the energy does not resolve the motion.
constexpr double kCoarse = 0.5;
// The share that may come back of the energies of two states: of the largest or of this step's.
constexpr double kLongestMemory = 0.1;
constexpr double kRounding = std::numeric_limits<double>::epsilon();

/// Whether an effect changes much over a short length, as contact does.
bool collides(const Model& model) {
  return std::any_of(model.effects.begin(), model.effects.end(),
                     [](const auto& effect) { return std::isfinite(effect->traits().length); });
}

}  // namespace

double powerOfEffects(Workspace& workspace, const Point& point) {
  double power = 0.0;
  for (const Workspace::Part& part : workspace.parts()) {
    if (part.driving) power += part.driving->power(point, part.scratch.get());
  }
  return power;
}

double fedByTime(Workspace& workspace, const Point& start, double h) {
  Energy now, then;
  const Point end{start.positions, start.velocities, start.time + h, start.effects};
  for (const Workspace::Part& part : workspace.parts()) {
    if (!part.driving || !part.driving->dependsOnTime(start)) continue;
    Sums sums;
    sums.energy = &now;
    part.effect->add(start, part.scratch.get(), sums);
    sums.energy = &then;
    part.effect->add(end, part.scratch.get(), sums);
  }
  return then.total() - now.total();
}

RoundingNoise::RoundingNoise(const Model& model) : mass_(model.masses.sum()) {
  for (const Spring& s : model.springs) stiffness_ += s.stiffness;
  Eigen::VectorXd held = Eigen::VectorXd::Zero(model.masses.size()), braked = held;
  for (const auto& effect : model.effects) effect->addBounds(held, braked);
  stiffness_ += held.sum();
}

double RoundingNoise::energy(const Vectors& positions, double h, double sum) const {
  const double position = 16.0 * kRounding * positions.cwiseAbs().maxCoeff();
  return 64.0 * kRounding * sum + position * position * (stiffness_ + mass_ / (h * h));
}

// Where stiff springs turn within a step, the truncation error of tr_bdf2 takes energy away and
// gives it back later: up to some percent of all energy in one step where a rope whips. No limit
// for each step can tell that from a gain, but the limit for all steps does. Where a step is too
// coarse for the motion as a whole, energy that comes back again and again would keep it from
// coming to rest; there the limit for each step stays. In collisions the limit for each step stays:
// bodies part with what a step gained there, and no later step takes it back. It stays for the
// other schemes, too: the implicit midpoint rule only reflects the stiffest motions (R(infinity) =
// -1) and keeps what they gain.
EnergyCheck::EnergyCheck(Workspace& workspace, Scheme scheme)
    : workspace_(workspace),
      rounding_(workspace.model()),
      ignored_effect_(scheme == Scheme::kXpbd ? find<Springs>(workspace.model()) : nullptr),
      limits_steps_(ignored_effect_ == nullptr &&
                    (scheme != Scheme::kTrBdf2 || collides(workspace.model()))),
      tolerance_(limits_steps_ || ignored_effect_ ? kTotalTolerance : kSwingTolerance) {
  for (Vectors* vectors : {&start_, &scratch_, &free_masses_}) {
    vectors->setZero(3, workspace.model().particleCount());
  }
}

const Vectors& EnergyCheck::freeMasses(const Drive& drive) {
  if (pinned_ == drive.pinned) return free_masses_;
  pinned_ = drive.pinned;
  for (Eigen::Index i = 0; i < free_masses_.cols(); ++i) {
    free_masses_.col(i).setConstant(drive.isPinned(i) ? 0.0 : workspace_.model().masses[i]);
  }
  return free_masses_;
}

Energy EnergyCheck::energyOfFree(const Point& point, const Drive& drive) {
  Energy energy;
  energy.kinetic = 0.5 * freeMasses(drive).cwiseProduct(point.velocities.cwiseAbs2()).sum();
  addEnergy(workspace_, point, ignored_effect_, energy);
  return energy;
}

double EnergyCheck::energyOfIgnored(const Point& point) {
  Energy energy;
  Sums sums;
  sums.energy = &energy;
  for (const Workspace::Part& part : workspace_.parts()) {
    if (part.effect == ignored_effect_) part.effect->add(point, part.scratch.get(), sums);
  }
  return energy.total();
}

double EnergyCheck::pinPower(const Point& point, const Drive& drive) {
  sumForces(workspace_, nullptr, point, scratch_);
  double power = 0.0;
  for (Eigen::Index i = 0; i < scratch_.cols(); ++i) {
    if (drive.isPinned(i)) power -= scratch_.col(i).dot(point.velocities.col(i));
  }
  return power;
}

void EnergyCheck::start(double h, const State& state, const Drive& drive) {
  h_ = h;
  const Point start = drive.point(state.positions, state.velocities, 0.0);
  start_ = state.positions;
  before_ = energyOfFree(start, drive);
  if (ignored_effect_ && restarted_) {
    balance_ = -energyOfIgnored(start);
  }
  restarted_ = false;
  fed_ = powerOfEffects(workspace_, start);
  power_ = 0.0;
  pins_move_ = false;
  for (Eigen::Index i = 0; i < start_.cols(); ++i) {
    pins_move_ = pins_move_ || (drive.isPinned(i) && !state.velocities.col(i).isZero(0.0));
  }
  if (!pins_move_) {
    prescribed_motion_work_ = fedByTime(workspace_, start, h);
    return;
  }
  power_ = pinPower(start, drive);
  scratch_ = start_;
  for (Eigen::Index i = 0; i < start_.cols(); ++i) {
    if (drive.isPinned(i)) scratch_.col(i) += h * state.velocities.col(i);
  }
  const Energy moved = energyOfFree(drive.point(scratch_, state.velocities, h), drive);
  prescribed_motion_work_ = moved.total() - before_.total();
}

bool EnergyCheck::gained(const State& end, const Drive& drive) {
  const Point point = drive.point(end.positions, end.velocities, h_);
  const Energy after = energyOfFree(point, drive);
  double power = std::max(fed_, powerOfEffects(workspace_, point));
  if (power > 0.0) {
    // What swings within the step ends at any velocity: the way that it has come tells more.
    scratch_ = (end.positions - start_) / h_;
    power = std::max(power, powerOfEffects(workspace_, drive.point(end.positions, scratch_, h_)));
  }
  // Shapes that move: by what they feed in, or by what they would if nothing gave way.
  double work = pins_move_ ? h_ * power : std::max(h_ * power, prescribed_motion_work_);
  if (drive.loads) {
    for (Eigen::Index i = 0; i < start_.cols(); ++i) {
      if (drive.isPinned(i)) continue;
      work += drive.loads->col(i).dot(end.positions.col(i) - start_.col(i));
    }
  }
  if (pins_move_) {
    work += std::max(prescribed_motion_work_, 0.5 * h_ * (power_ + pinPower(point, drive)));
  }
  scale_ = before_.kinetic + before_.elastic + after.kinetic + after.elastic +
           std::abs(after.gravity - before_.gravity) + std::abs(work);
  gain_ = after.total() - before_.total() - work;
  lost_ = std::min(gain_, 0.0) + std::min(work, 0.0);
  kinetic_ = after.kinetic;
  moving_ = after.kinetic + after.elastic;
  noise_ = rounding_.energy(end.positions, h_, scale_ + std::abs(before_.gravity));
  // Losses of long ago are no excuse for a gain.
  const double reserve = kLongestMemory * std::max(scale_, 2.0 * reference_);
  earlier_ = ignored_effect_ ? balance_ : std::max(balance_, -reserve);
  const bool coarse =
      std::abs(after.gravity - before_.gravity) > kCoarse * std::max(moving_, reference_);
  return !((!(limits_steps_ || coarse) || ignored_effect_ ||
            gain_ <= kStepTolerance * scale_ + noise_) &&
           earlier_ + gain_ <= tolerance_ * std::max(scale_, 2.0 * reference_) + noise_);
}

bool EnergyCheck::slowDown(State& end, const Drive& drive) {
  gained(end, drive);
  const double excess = ignored_effect_ ? earlier_ + gain_ : gain_;
  if (excess <= noise_) return true;
  if (!(excess <= kinetic_)) return false;
  const double share = std::sqrt(1.0 - excess / kinetic_);
  for (Eigen::Index i = 0; i < end.velocities.cols(); ++i) {
    if (!drive.isPinned(i)) end.velocities.col(i) *= share;
  }
  gain_ -= excess;
  return true;
}

void EnergyCheck::accept() {
  reference_ = std::max(moving_, reference_ + lost_);
  balance_ = earlier_;
  if (std::abs(gain_) > noise_) balance_ += gain_;
}

void EnergyCheck::restart() {
  balance_ = reference_ = 0.0;
  restarted_ = true;
}

}  // namespace mass_spring
