#include "stepper.h"

#include <algorithm>
#include <array>

#include "mass_spring_sim/measures.h"

namespace mass_spring {

Stepper::Stepper(const Model& model, const SolverOptions& options)
    : model_(model), options_(options), work_(model.start) {
  if (info(options.scheme).implicit) {
    implicit_.emplace(model, options);
  } else {
    explicit_.emplace(model, options.scheme);
  }
  pin_ends_ = pin_velocities_ = model_.start.positions;
}

SubstepReport Stepper::advance(Scheme scheme, double h, const Drive& drive) {
  if (explicit_) return explicit_->advance(h, drive, work_);
  if (scheme == Scheme::kLinearImplicitEuler || scheme == Scheme::kRos3) {
    return implicit_->rosenbrock.advance(scheme, h, drive, work_);
  }
  return implicit_->stages.advance(scheme, h, drive, work_);
}

Stepper::Outcome Stepper::attempt(Scheme scheme, int substeps, double h, const Drive& drive,
                                  const State& state, StepReport& report) {
  work_.positions = state.positions;
  work_.velocities = state.velocities;
  for (Eigen::Index i = 0; i < work_.velocities.cols(); ++i) {
    if (drive.isPinned(i)) work_.velocities.col(i) = pin_velocities_.col(i);
  }
  if (implicit_) {
    implicit_->stages.restore();
    implicit_->energy.start(h, work_, drive);
  }
  bool converged = true;
  double error = 0.0;
  bool estimated = true;
  for (int s = 1; s <= substeps; ++s) {
    const SubstepReport sub = advance(scheme, h / substeps, drive);
    ++report.substeps;
    report.newton_iterations += sub.newton_iterations;
    report.linear_iterations += sub.linear_iterations;
    report.factorizations += sub.factorizations;
    report.projected_springs += sub.projected_springs;
    report.residual = std::max(report.residual, sub.residual);
    converged = converged && sub.converged;
    estimated = estimated && sub.estimated_error >= 0.0;
    error += sub.estimated_error;
    if (!work_.positions.allFinite() || !work_.velocities.allFinite()) return Outcome::kNotFinite;
    // Pinned particles move evenly from where they are to where the step ends.
    const double left = static_cast<double>(substeps - s) / substeps;
    for (Eigen::Index i = 0; i < work_.positions.cols(); ++i) {
      if (!drive.isPinned(i)) continue;
      work_.positions.col(i) = (1.0 - left) * pin_ends_.col(i) + left * state.positions.col(i);
    }
  }
  report.estimated_error = estimated ? error : -1.0;
  if (!converged) return Outcome::kUnconverged;
  if (implicit_ && implicit_->energy.gained(work_, drive)) return Outcome::kGainedEnergy;
  return Outcome::kConverged;
}

StepReport Stepper::step(double h, const Pins& pins, const Vectors* loads, State& state) {
  StepReport report;
  const Drive drive{pins.mask(), loads};
  pin_ends_ = state.positions;
  pins.prescribe(pin_ends_);
  pin_velocities_ = (pin_ends_ - state.positions) / h;

  struct Rung {
    Scheme scheme;
    int refinement;
  };
  static constexpr int kRungs = 5;
  const std::array<Rung, kRungs> ladder = {{{options_.scheme, 1},
                                            {options_.scheme, 2},
                                            {options_.scheme, 4},
                                            {options_.scheme, 8},
                                            {Scheme::kImplicitEuler, 8}}};
  const int last = implicit_ ? kRungs - 1 : kRungs - 2;
  Outcome outcome = Outcome::kNotFinite;
  int rung = 0;
  std::string why;
  for (;; ++rung) {
    const Rung& way = ladder[static_cast<std::size_t>(rung)];
    report.residual = 0.0;
    outcome = attempt(way.scheme, options_.substeps * way.refinement, h, drive, state, report);
    if (outcome == Outcome::kConverged || rung == last) break;
    if (rung == 0) {
      why = outcome == Outcome::kUnconverged    ? "did not converge"
            : outcome == Outcome::kGainedEnergy ? "gained energy"
                                                : "was not finite";
    }
    ++report.rejected;
  }

  if (outcome == Outcome::kNotFinite) {
    report.status = StepStatus::kFailed;
    report.message = whereNotFinite();
    return report;
  }
  if (rung > 0) {
    const Rung& way = ladder[static_cast<std::size_t>(rung)];
    report.status = StepStatus::kDegraded;
    report.message = info(options_.scheme).name + " " + why + ", redone with " +
                     info(way.scheme).name + " in " +
                     std::to_string(options_.substeps * way.refinement) + " sub-steps";
    if (outcome == Outcome::kUnconverged) report.message += ", still above the tolerance";
    if (outcome == Outcome::kGainedEnergy) report.message += ", still gaining energy";
  }
  if (implicit_) {
    implicit_->stages.keep();
    implicit_->energy.accept();
  }
  state.positions.swap(work_.positions);
  state.velocities.swap(work_.velocities);
  return report;
}

void Stepper::restart() {
  if (!implicit_) return;
  implicit_->stages.forget();
  implicit_->energy.restart();
}

std::string Stepper::whereNotFinite() const {
  const std::uint32_t particle = firstNotFinite(work_).value();
  const ModelObject& object = model_.objectOf(particle);
  std::string message = "object " + object.name + ", particle " +
                        std::to_string(particle - object.first_particle) + " is not finite after " +
                        info(options_.scheme).name;
  if (explicit_) message += ": the step is too large for an explicit scheme";
  return message;
}

}  // namespace mass_spring
