#include "stepper.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "mass_spring_sim/measures.h"

namespace mass_spring {

namespace {

// More than a budget could use, and few enough that a wrong clock does no harm. An implicit scheme
// of second order then errs a thousandth of what it does in one sub-step: what is left is about
// what Newton's tolerance leaves in each sub-step, and more of them would only add that up.
constexpr int kMostExplicit = 100000, kMostImplicit = 32;

// Of Verlet's largest stable step where the springs are at the start of a step: they move on.
constexpr double kStableShare = 0.75;
// Such scenes are for implicit schemes; 2^kFinest times as many still can be counted.
constexpr double kMostStable = 100000;

/// The first particle that is not finite or beyond a limit, and which; nothing if there is none.
std::optional<std::string> findBeyondLimits(const Model& model, const State& state) {
  const double max_speed = Limits::kSpeedReserve * model.limits.max_speed;
  for (Eigen::Index i = 0; i < state.positions.cols(); ++i) {
    std::ostringstream problem;
    const double way = (state.positions.col(i) - model.start.positions.col(i)).stableNorm();
    const double speed = state.velocities.col(i).stableNorm();
    if (!std::isfinite(way) || !std::isfinite(speed)) {
      problem << "is not finite";
    } else if (way > model.limits.max_extent) {
      problem << "is " << way
              << " m from where it started (limits.max_extent: " << model.limits.max_extent
              << " m)";
    } else if (speed > max_speed) {
      problem << "moves at " << speed << " m/s (at most " << Limits::kSpeedReserve
              << " times limits.max_speed: " << max_speed << " m/s)";
    } else {
      continue;
    }
    const auto particle = static_cast<std::uint32_t>(i);
    const ModelObject& object = model.objectOf(particle);
    return "object " + object.name + ", particle " +
           std::to_string(particle - object.first_particle) + ' ' + problem.str();
  }
  return std::nullopt;
}

}  // namespace

Stepper::Stepper(const Model& model, const SolverOptions& options,
                 std::shared_ptr<ThreadPool> threads)
    : model_(model), workspace_(model, std::move(threads)), options_(options), work_(model.start) {
  if (options.scheme == Scheme::kXpbd) {
    xpbd_.emplace(workspace_, options);
  } else if (info(options.scheme).implicit) {
    implicit_.emplace(workspace_, options);
  } else {
    explicit_.emplace(workspace_, options.scheme);
  }
  if (explicit_) {
    watch_.emplace(workspace_, options.scheme);
  } else {
    energy_.emplace(workspace_, options.scheme);
  }
  if (options.accuracy) {
    // The embedded formulas are of order 2 (rk4: 3), and so is the estimate per unit of time.
    control_.emplace(*options.accuracy, options.scheme == Scheme::kRk4 ? 3 : 2);
    before_substep_ = model.start;
    if (options.scheme == Scheme::kSymplecticEuler) spectrum_.emplace(model);
  }
  if (options.budget) budget_.emplace(*options.budget);
  pin_ends_ = pin_velocities_ = model_.start.positions;
  farthest_start_ = model_.start.positions.colwise().norm().maxCoeff();
}

void Stepper::begin(double h, const Drive& drive, const State& state, StepReport& report) {
  work_.positions = state.positions;
  work_.velocities = state.velocities;
  for (Eigen::Index i = 0; i < work_.velocities.cols(); ++i) {
    if (drive.isPinned(i)) work_.velocities.col(i) = pin_velocities_.col(i);
  }
  if (implicit_) implicit_->stages.restore();
  taken_ = 0;
  if (explicit_) explicit_->beginStep();
  if (energy_) energy_->start(h, work_, drive);
  report.residual = 0.0;
  report.estimated_error = 0.0;
}

Stepper::Outcome Stepper::advance(Scheme scheme, double substep, double from, double to, double h,
                                  const Drive& drive, const State& state, StepReport& report) {
  const Drive then{drive.pinned, drive.loads, drive.effects, drive.time + from * h};
  beginSubstep(workspace_, work_.positions, work_.velocities, substep);
  const SubstepReport sub = explicit_ ? explicit_->advance(substep, then, work_)
                            : xpbd_   ? xpbd_->advance(substep, then, work_)
                            : isRosenbrock(scheme)
                                ? implicit_->rosenbrock->advance(scheme, substep, then, work_)
                                : implicit_->stages.advance(scheme, substep, then, work_);
  ++report.substeps;
  ++taken_;
  return conclude(sub, to, drive, state, report);
}

Stepper::Outcome Stepper::conclude(const SubstepReport& sub, double to, const Drive& drive,
                                   const State& state, StepReport& report) {
  report.newton_iterations += sub.newton_iterations;
  report.linear_iterations += sub.linear_iterations;
  report.factorizations += sub.factorizations;
  report.projected_springs += sub.projected_springs;
  report.residual = std::max(report.residual, sub.residual);
  substep_error_ = sub.estimated_error;
  const bool passed = endSubstep(workspace_, work_.positions);
  if (!withinLimits()) return Outcome::kBeyondLimits;
  // Pinned particles move evenly from where they are to where the step ends.
  for (Eigen::Index i = 0; i < work_.positions.cols(); ++i) {
    if (!drive.isPinned(i)) continue;
    work_.positions.col(i) = to * pin_ends_.col(i) + (1.0 - to) * state.positions.col(i);
  }
  if (passed) return Outcome::kPassedThrough;
  return sub.converged ? Outcome::kConverged : Outcome::kUnconverged;
}

Stepper::Outcome Stepper::end(Outcome outcome, const Drive& drive) {
  if (outcome != Outcome::kConverged || !energy_) return outcome;
  return energy_->gained(work_, drive) ? Outcome::kGainedEnergy : outcome;
}

Stepper::Outcome Stepper::attempt(Scheme scheme, int substeps, double h, const Drive& drive,
                                  const State& state, StepReport& report) {
  begin(h, drive, state, report);
  Outcome outcome = Outcome::kConverged;
  for (int s = 0; s < substeps; ++s) {
    const Outcome one = advance(scheme, h / substeps, static_cast<double>(s) / substeps,
                                static_cast<double>(s + 1) / substeps, h, drive, state, report);
    if (one == Outcome::kBeyondLimits || one == Outcome::kPassedThrough) return one;
    if (one == Outcome::kUnconverged) outcome = one;
    report.estimated_error = substep_error_ < 0.0 ? -1.0 : report.estimated_error + substep_error_;
  }
  return end(outcome, drive);
}

Stepper::Outcome Stepper::attemptSafely(int substeps, double h, const Drive& drive,
                                        const State& state, StepReport& report) {
  begin(h, drive, state, report);
  report.scheme = xpbd_ ? Scheme::kXpbd : Scheme::kImplicitEuler;
  report.estimated_error = -1.0;
  Outcome outcome = Outcome::kConverged;
  for (int s = 0; s < substeps; ++s) {
    const Drive then{drive.pinned, drive.loads, drive.effects, drive.time + s * h / substeps};
    energy_->start(h / substeps, work_, then);
    const Outcome one = advance(report.scheme, h / substeps, static_cast<double>(s) / substeps,
                                static_cast<double>(s + 1) / substeps, h, drive, state, report);
    if (one == Outcome::kBeyondLimits) return one;
    if (one != Outcome::kConverged && outcome != Outcome::kPassedThrough) outcome = one;
    // Short of its root, or where the springs' energy is not convex, even implicit Euler can gain;
    // what it gains is then kinetic, as no sub-step ends above Phi at rest.
    if (!energy_->slowDown(work_, then) && outcome != Outcome::kPassedThrough) {
      outcome = Outcome::kGainedEnergy;
    }
    if (s + 1 < substeps) energy_->accept();
  }
  return outcome;
}

Stepper::Outcome Stepper::attemptAccurately(double h, const Drive& drive, const State& state,
                                            StepReport& report) {
  // Places in the step are counted in its finest sub-steps.
  constexpr int kUnits = 1 << ErrorControl::kFinest;
  const double whole = static_cast<double>(kUnits) * options_.substeps;
  begin(h, drive, state, report);
  for (double at = 0.0; at < whole;) {
    const double size = kUnits >> control_->level();
    before_substep_.positions = work_.positions;
    before_substep_.velocities = work_.velocities;
    const Outcome one = advance(options_.scheme, size / whole * h, at / whole, (at + size) / whole,
                                h, drive, state, report);
    const double error =
        one == Outcome::kConverged ? substep_error_ : std::numeric_limits<double>::infinity();
    if (control_->accepts(error, size / whole * h)) {
      at += size;
      report.estimated_error += error;
      control_->keepAligned(std::fmod(at, 2.0 * size) == 0.0);
      continue;
    }
    if (one != Outcome::kConverged && control_->level() == ErrorControl::kFinest) return one;
    ++report.rejected;
    work_.positions.swap(before_substep_.positions);
    work_.velocities.swap(before_substep_.velocities);
  }
  return end(Outcome::kConverged, drive);
}

Stepper::Outcome Stepper::attemptVerlet(double h, const Drive& drive, const State& state,
                                        StepReport& report) {
  const double stable =
      kStableShare *
      stableVerletStep(spectrum_->at(state.positions, state.effects.rest_lengths, drive.pinned));
  const double least = std::clamp(std::ceil(h / stable), 1.0 * options_.substeps, kMostStable);
  for (;;) {
    begin(h, drive, state, report);
    beginSubstep(workspace_, work_.positions, work_.velocities, h);
    const int substeps = static_cast<int>(least) << control_->level();
    const SubstepReport sub = explicit_->advanceVerlet(substeps, h, drive, work_);
    report.substeps += static_cast<std::uint32_t>(substeps);
    taken_ = substeps;
    const Outcome outcome = conclude(sub, 1.0, drive, state, report);
    report.estimated_error = sub.estimated_error;
    if (control_->accepts(sub.estimated_error, h)) return outcome;
    if (control_->level() == ErrorControl::kFinest) return Outcome::kBeyondLimits;
    ++report.rejected;
  }
}

Stepper::Outcome Stepper::attemptWithin(double h, const Drive& drive, const State& state,
                                        StepReport& report) {
  const bool cheap = implicit_ && !budget_->affordable();
  const Scheme scheme = cheap ? Scheme::kLinearImplicitEuler : options_.scheme;
  // An explicit scheme has a least number for the sake of stability.
  const int least = explicit_ ? options_.substeps : 1;
  if (cheap) budget_->forget();
  report.scheme = scheme;
  begin(h, drive, state, report);
  Outcome outcome = Outcome::kConverged;
  for (double at = 0.0; at < 1.0;) {
    const double left = 1.0 - at;
    const int most = !implicit_
                         ? kMostExplicit
                         : std::max(1, static_cast<int>(std::ceil(kMostImplicit * left - 1e-9)));
    const int substeps = std::max(budget_->affordableSubsteps(cheap, most),
                                  static_cast<int>(std::ceil(least * left - 1e-9)));
    const double to = substeps == 1 ? 1.0 : at + left / substeps;
    const double spent = budget_->spent();
    const Outcome one = advance(scheme, (to - at) * h, at, to, h, drive, state, report);
    budget_->learn(cheap, budget_->spent() - spent);
    if (one == Outcome::kBeyondLimits) return one;
    if (one != Outcome::kConverged && outcome != Outcome::kPassedThrough) outcome = one;
    report.estimated_error = substep_error_ < 0.0 ? -1.0 : report.estimated_error + substep_error_;
    at = to;
  }
  return end(outcome, drive);
}

StepReport Stepper::step(double h, const Pins& pins, const Vectors* loads, State& state) {
  StepReport report;
  if (budget_) budget_->start();
  const Drive drive{pins.mask(), loads, state.effects, state.time};
  pins.prescribe(pin_ends_);
  for (Eigen::Index i = 0; i < pin_ends_.cols(); ++i) {
    if (drive.isPinned(i)) pin_velocities_.col(i) = (pin_ends_.col(i) - state.positions.col(i)) / h;
  }

  report.scheme = options_.scheme;
  Outcome outcome =
      budget_     ? attemptWithin(h, drive, state, report)
      : !control_ ? attempt(options_.scheme, options_.substeps, h, drive, state, report)
      : options_.scheme == Scheme::kSymplecticEuler ? attemptVerlet(h, drive, state, report)
                                                    : attemptAccurately(h, drive, state, report);
  if (control_ && outcome == Outcome::kConverged && control_->level() == ErrorControl::kFinest) {
    report.status = StepStatus::kDegraded;
    report.message = "the accuracy asked for needs more sub-steps than " +
                     std::to_string(1 << ErrorControl::kFinest);
  }

  // A budget that is spent pays for no other attempt.
  const bool spent = budget_ && energy_ && outcome != Outcome::kConverged &&
                     outcome != Outcome::kBeyondLimits && energy_->slowDown(work_, drive);
  if (spent) {
    report.status = StepStatus::kDegraded;
    report.message = name(report.scheme) + std::string(" ") +
                     (outcome == Outcome::kUnconverged     ? "did not converge"
                      : outcome == Outcome::kPassedThrough ? "let parts pass through one another"
                                                           : "gained energy, and was slowed down");
  } else if (outcome != Outcome::kConverged) {
    const char* why = outcome == Outcome::kUnconverged     ? "did not converge"
                      : outcome == Outcome::kGainedEnergy  ? "gained energy"
                      : outcome == Outcome::kPassedThrough ? "let parts pass through one another"
                                                           : "left the limits of the scene";
    const std::string first = name(report.scheme);
    const int substeps = options_.substeps * (control_ ? 1 << control_->level() : 1);
    int refined = substeps;
    for (int rung = 1; rung <= 3 && outcome != Outcome::kConverged; ++rung) {
      ++report.rejected;
      report.scheme = options_.scheme;
      refined = substeps << rung;
      outcome = attempt(report.scheme, refined, h, drive, state, report);
    }
    if (energy_ && outcome != Outcome::kConverged) {
      ++report.rejected;
      outcome = attemptSafely(refined, h, drive, state, report);
    }
    if (control_) control_->refine();
    report.status = StepStatus::kDegraded;
    report.message = first + " " + why + ", redone with " + name(report.scheme) + " in " +
                     std::to_string(refined) + " sub-steps";
    if (outcome == Outcome::kUnconverged) report.message += ", still above the tolerance";
    if (outcome == Outcome::kGainedEnergy) report.message += ", still gaining energy";
    if (outcome == Outcome::kPassedThrough) {
      report.message += ", still letting parts pass through one another";
    }
  }
  if (budget_) report.budget_used = budget_->spent() / budget_->seconds();
  if (outcome == Outcome::kBeyondLimits) {
    report.status = StepStatus::kFailed;
    report.message = whyFailed();
    return report;
  }
  if (implicit_) implicit_->stages.keep();
  if (energy_) energy_->accept();
  if (watch_) {
    const int evaluations = report.scheme == Scheme::kRk4 ? 4 : 1;
    watch_->observe({h, h / taken_, evaluations * taken_, explicit_->pinWork()}, state, work_,
                    drive);
    if (watch_->gained()) {
      report.status = StepStatus::kDegraded;
      report.message += (report.message.empty() ? "" : "; ") + std::string(name(report.scheme)) +
                        " gained energy: the step is too large for an explicit scheme";
    }
  }
  state.positions.swap(work_.positions);
  state.velocities.swap(work_.velocities);
  return report;
}

void Stepper::restart() {
  if (energy_) energy_->restart();
  if (watch_) watch_->restart();
  if (!implicit_) return;
  implicit_->system.restart();
  implicit_->stages.forget();
}

void Stepper::goBack() {
  if (watch_) watch_->goBack();
}

void Stepper::continueFrom(const Stepper& other) {
  if (watch_ && other.watch_) watch_->continueFrom(*other.watch_);
}

bool Stepper::withinLimits() const {
  // Where all particles together are within, each of them is. Sums that are no number are not.
  const double extent = model_.limits.max_extent - farthest_start_;
  const double speed = Limits::kSpeedReserve * model_.limits.max_speed;
  if (extent > 0.0 && work_.positions.squaredNorm() <= extent * extent &&
      work_.velocities.squaredNorm() <= speed * speed) {
    return true;
  }
  return !findBeyondLimits(model_, work_).has_value();
}

std::string Stepper::whyFailed() const {
  std::string message = findBeyondLimits(model_, work_).value() + " after " + name(options_.scheme);
  if (explicit_) message += ": the step is too large for an explicit scheme";
  return message;
}

}  // namespace mass_spring
