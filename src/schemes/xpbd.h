#pragma once

#include <optional>
#include <vector>

#include "effects/spring_relaxation.h"
#include "effects/springs.h"
#include "mass_spring_sim/model.h"
#include "schemes/rosenbrock.h"
#include "schemes/step_system.h"

namespace mass_spring {

/// Extended position based dynamics with one iteration in each sub-step: first all that is no
/// spring, by a linearly implicit step, then one spring after the other (SpringRelaxation). It is
/// stable at any step without solving for the springs, and as cheap as evaluating their forces;
/// what it errs by is that each of them hears of the others only in the next sub-step. Coarse steps
/// make springs soft and what swings slow.
class Xpbd {
 public:
  Xpbd(const Model& model, const SolverOptions& options);

  /// Advances positions and velocities by h [s].
  SubstepReport advance(double h, const Drive& drive, State& state);

 private:
  void findMobilities(const Drive& drive);
  /// What acts without springs, where none of it depends on positions or velocities.
  void advanceFreely(double h, const Drive& drive, State& state) const;

  struct Others {
    Others(const Model& model, const SolverOptions& options)
        : system(model, options, model.springs_effect), scheme(model, options, system) {}
    StepSystem system;
    Rosenbrock scheme;
  };

  const Model& model_;
  std::optional<SpringRelaxation> springs_;
  std::optional<Others> others_;  // if something needs it
  Vectors before_;
  std::vector<char> pinned_;  // that these belong to, 0 for pinned particles:
  Vectors mobilities_;        // 1/kg per coordinate
  Vectors accelerations_;     // m/s^2, by constant effects
};

}  // namespace mass_spring
