#pragma once

#include <optional>
#include <string>

#include "loads.h"
#include "mass_spring_sim/model.h"
#include "mass_spring_sim/pins.h"
#include "mass_spring_sim/step_report.h"
#include "schemes/explicit_scheme.h"
#include "schemes/implicit_euler.h"

namespace mass_spring {

/// Advances a state by whole steps with the scheme asked for. An implicit step that does not
/// converge is redone: with 2, 4, 8 times the sub-steps, then by implicit Euler with its line
/// search. What happened is in the report; a step that fails leaves the state untouched.
class Stepper {
 public:
  Stepper(const Model& model, const SolverOptions& options);

  /// @param h     s, the whole step
  /// @param pins  their targets are reached at the end of the step
  /// @param loads N per particle, or nullptr
  StepReport step(double h, const Pins& pins, const Vectors* loads, State& state);
  std::size_t matrixNonzeros() const { return implicit_ ? implicit_->matrixNonzeros() : 0; }

 private:
  enum class Outcome { kConverged, kUnconverged, kNotFinite };
  Outcome attempt(Scheme scheme, int substeps, double h, const Pins& pins, const Vectors* loads,
                  const State& state, StepReport& report);
  SubstepReport advance(Scheme scheme, double h, const Drive& drive);
  std::string whereNotFinite() const;

  const Model& model_;
  SolverOptions options_;
  std::optional<ExplicitScheme> explicit_;
  std::optional<ImplicitEuler> implicit_;
  State work_;
  Vectors pin_ends_, pin_positions_;  // at the end of the step and of the sub-step
};

}  // namespace mass_spring
