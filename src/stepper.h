#pragma once

#include <memory>
#include <optional>
#include <string>

#include "energy_check.h"
#include "energy_watch.h"
#include "error_control.h"
#include "loads.h"
#include "local_spectrum.h"
#include "mass_spring_sim/model.h"
#include "mass_spring_sim/pins.h"
#include "mass_spring_sim/step_report.h"
#include "schemes/explicit_scheme.h"
#include "schemes/rosenbrock.h"
#include "schemes/stage_scheme.h"
#include "schemes/xpbd.h"
#include "step_budget.h"

namespace mass_spring {

/// Advances a state by whole steps with the scheme asked for, in the sub-steps asked for, or as
/// many as an accuracy needs or a budget buys. A step that does not converge, leaves the limits of
/// the scene or lets parts pass through one another, or in which an implicit scheme gains energy
/// that nothing gave it, is redone: with 2, 4, 8 times the sub-steps, then by implicit Euler with
/// its line search, which descends on a function bounded below and therefore always ends (xpbd by
/// itself, slowed down where it gained energy). Explicit schemes have no such last resort: a step
/// in which they gained energy is degraded, and taken. The report says what happened; a step that
/// fails leaves the state untouched.
class Stepper {
 public:
  /// @param options  with a scheme that is not auto
  /// @param threads  of another stepper that is no longer used; nullptr = its own
  Stepper(const Model& model, const SolverOptions& options,
          std::shared_ptr<ThreadPool> threads = nullptr);

  /// @param h     s, the whole step
  /// @param pins  their targets are reached at the end of the step
  /// @param loads N per particle, or nullptr
  StepReport step(double h, const Pins& pins, const Vectors* loads, State& state);
  /// The next step does not follow the last one: forgets what was kept of it.
  void restart();
  /// The next step follows the last one that this vouched for, or the first one since restart().
  void goBack();
  /// May the state after the last step be gone back to when a later one fails? It may, unless an
  /// explicit scheme made it and all of its energy has not been looked at, or was too much.
  bool vouches() const { return !watch_ || watch_->vouches(); }
  /// Does a step that fails leave a state that may have been exploding for some steps?
  bool mayExplode() const { return watch_.has_value(); }
  /// Goes on from another stepper, of a model of the same particles: with what that knew of the
  /// energy.
  void continueFrom(const Stepper& other);
  /// Not while it steps.
  Workspace& workspace() { return workspace_; }
  std::size_t matrixNonzeros() const { return implicit_ ? implicit_->system.nonzeros() : 0; }

 private:
  enum class Outcome { kConverged, kUnconverged, kGainedEnergy, kPassedThrough, kBeyondLimits };
  static bool isRosenbrock(Scheme scheme) {
    return scheme == Scheme::kLinearImplicitEuler || scheme == Scheme::kRos3;
  }
  /// What implicit schemes need, all on one step matrix.
  struct Implicit {
    Implicit(Workspace& workspace, const SolverOptions& options)
        : system(workspace, options), stages(workspace, options, system) {
      if (isRosenbrock(options.scheme) || options.budget) {
        rosenbrock.emplace(workspace, options, system);
      }
    }
    StepSystem system;
    StageScheme stages;
    std::optional<Rosenbrock> rosenbrock;
  };
  /// One attempt at a step; what it reaches is in work_.
  Outcome attempt(Scheme scheme, int substeps, double h, const Drive& drive, const State& state,
                  StepReport& report);
  /// The last resort: implicit Euler or xpbd, each sub-step of which is slowed down if it gained
  /// energy.
  Outcome attemptSafely(int substeps, double h, const Drive& drive, const State& state,
                        StepReport& report);
  Outcome attemptAccurately(double h, const Drive& drive, const State& state, StepReport& report);
  /// With symplectic Euler, whose sub-steps are chosen for a whole step at a time.
  Outcome attemptVerlet(double h, const Drive& drive, const State& state, StepReport& report);
  Outcome attemptWithin(double h, const Drive& drive, const State& state, StepReport& report);
  void begin(double h, const Drive& drive, const State& state, StepReport& report);
  /// One sub-step of `substep` [s], from `from` to `to`, both as parts of the step of h [s].
  Outcome advance(Scheme scheme, double substep, double from, double to, double h,
                  const Drive& drive, const State& state, StepReport& report);
  /// Counts what a sub-step did and puts the pinned particles where they are at `to`.
  Outcome conclude(const SubstepReport& sub, double to, const Drive& drive, const State& state,
                   StepReport& report);
  Outcome end(Outcome outcome, const Drive& drive);
  /// Is work_ finite, and within the model's limits?
  bool withinLimits() const;
  std::string whyFailed() const;

  const Model& model_;
  Workspace workspace_;
  SolverOptions options_;
  std::optional<ExplicitScheme> explicit_;
  std::optional<Implicit> implicit_;
  std::optional<Xpbd> xpbd_;
  std::optional<EnergyCheck> energy_;  // of what is stable at any step
  std::optional<EnergyWatch> watch_;   // of explicit schemes
  std::optional<ErrorControl> control_;
  std::optional<LocalSpectrum> spectrum_;  // symplectic Euler with an accuracy
  std::optional<StepBudget> budget_;
  State work_;
  State before_substep_;               // only with an accuracy
  Vectors pin_ends_, pin_velocities_;  // pinned columns
  double farthest_start_ = 0.0;        // m, from the origin
  int taken_ = 0;                      // sub-steps, in the last attempt
  double substep_error_ = 0.0;         // m, estimate of the last sub-step; -1 = none
};

}  // namespace mass_spring
