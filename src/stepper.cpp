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
    explicit_.emplace(model, options.scheme == Scheme::kSymplecticEuler);
  }
  pin_ends_ = pin_positions_ = model.start.positions;
}

SubstepReport Stepper::advance(Scheme scheme, double h, const Drive& drive) {
  if (explicit_) return explicit_->advance(h, drive, work_);
  return scheme == Scheme::kLinearImplicitEuler ? implicit_->advanceLinearly(h, drive, work_)
                                                : implicit_->advance(h, drive, work_);
}

Stepper::Outcome Stepper::attempt(Scheme scheme, int substeps, double h, const Pins& pins,
                                  const Vectors* loads, const State& state, StepReport& report) {
  work_.positions = state.positions;
  work_.velocities = state.velocities;
  const double sub_h = h / substeps;
  bool converged = true;
  for (int s = 1; s <= substeps; ++s) {
    // Pinned particles move evenly from where they are to where the step ends.
    const double left = static_cast<double>(substeps - s) / substeps;
    pin_positions_ = (1.0 - left) * pin_ends_ + left * state.positions;
    const SubstepReport sub = advance(scheme, sub_h, Drive{pins.mask(), pin_positions_, loads});
    ++report.substeps;
    report.newton_iterations += sub.newton_iterations;
    report.linear_iterations += sub.linear_iterations;
    report.factorizations += sub.factorizations;
    report.projected_springs += sub.projected_springs;
    report.residual = std::max(report.residual, sub.residual);
    converged = converged && sub.converged;
    if (!work_.positions.allFinite() || !work_.velocities.allFinite()) return Outcome::kNotFinite;
  }
  return converged ? Outcome::kConverged : Outcome::kUnconverged;
}

StepReport Stepper::step(double h, const Pins& pins, const Vectors* loads, State& state) {
  StepReport report;
  pin_ends_ = state.positions;
  pins.prescribe(pin_ends_);

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
  Outcome outcome = Outcome::kNotFinite;
  int rung = 0;
  for (;; ++rung) {
    const Rung& way = ladder[static_cast<std::size_t>(rung)];
    const int substeps = options_.substeps * way.refinement;
    report.residual = 0.0;
    outcome = attempt(way.scheme, substeps, h, pins, loads, state, report);
    if (outcome == Outcome::kConverged || !implicit_ || rung + 1 == kRungs) break;
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
    report.message = "redone with " + info(way.scheme).name + " in " +
                     std::to_string(options_.substeps * way.refinement) + " sub-steps";
    if (outcome == Outcome::kUnconverged) report.message += ", still above the tolerance";
  }
  state.positions.swap(work_.positions);
  state.velocities.swap(work_.velocities);
  return report;
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
