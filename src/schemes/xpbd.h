#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "effects/spring_relaxation.h"
#include "effects/springs.h"
#include "schemes/rosenbrock.h"
#include "schemes/step_system.h"

namespace mass_spring {

/// Extended position based dynamics with one iteration in each sub-step: constant forces, then one
/// spring after the other (SpringRelaxation), and with the velocities that come of it a linearly
/// implicit step of all that is left, so that contact has the last word. It is stable at any step
/// without solving for the springs, and as cheap as evaluating their forces; what it errs by is
/// that each of them hears of the others only in the next sub-step. Coarse steps make springs soft
/// and what swings slow.
class Xpbd {
 public:
  Xpbd(Workspace& workspace, const SolverOptions& options);

  /// Advances positions and velocities by h [s].
  SubstepReport advance(double h, const Drive& drive, State& state);

 private:
  void findMobilities(const Drive& drive);
  /// By constant effects and loads alone.
  void advanceFreely(double h, const Drive& drive, State& state) const;

  struct Others {
    Others(Workspace& workspace, const SolverOptions& options,
           const std::function<bool(const Effect&)>& part)
        : system(workspace, options, part), scheme(workspace, options, system) {}
    StepSystem system;
    Rosenbrock scheme;
  };

  Workspace& workspace_;
  std::optional<SpringRelaxation> springs_;
  std::optional<Others> others_;  // if there are any
  Vectors before_;
  std::vector<char> pinned_;  // that these belong to, 0 for pinned particles:
  Vectors mobilities_;        // 1/kg per coordinate
  Vectors accelerations_;     // m/s^2, by constant effects
};

}  // namespace mass_spring
