#pragma once

#include "schemes/step_system.h"

namespace mass_spring {

/// Turns the difference of a step and its embedded formula into an estimate of the error. For stiff
/// springs the raw difference is far too large: (I - w J)^-1 takes from it what the scheme itself
/// damps away at once (Shampine 1984; Hosea and Shampine 1996, section 4).
class ErrorFilter {
 public:
  ErrorFilter(Workspace& workspace, StepSystem& system);

  /// The system must hold the matrix of weight w, decoupled.
  /// @param positions, velocities  the raw difference [m, m/s]; overwritten
  /// @return m, root mean square over the free particles
  double apply(double w, const Drive& drive, const Point& end, Vectors& positions,
               Vectors& velocities, SubstepReport& report);

 private:
  Workspace& workspace_;
  StepSystem& system_;
  Vectors still_, right_side_;
};

}  // namespace mass_spring
