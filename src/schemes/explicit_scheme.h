#pragma once

#include <vector>

#include "schemes/drive.h"

namespace mass_spring {

/// Schemes that only evaluate forces: explicit Euler (course notes eq. 10-11) moves with the old
/// velocities, symplectic Euler with the new ones; rk4 is the classical Runge-Kutta method.
///
/// Symplectic Euler's velocities are those of a scheme of second order half a sub-step ago. Where
/// an accuracy is asked for, half a kick at the start of a step and half a one at its end put that
/// right: then it is the Stoermer-Verlet scheme, at the price of one more evaluation in each step.
class ExplicitScheme {
 public:
  ExplicitScheme(Workspace& workspace, Scheme scheme);
  /// Advances positions and velocities by h [s].
  SubstepReport advance(double h, const Drive& drive, State& state);
  /// A step begins, or begins again: nothing has been done in it.
  void beginStep() { pin_work_ = 0.0; }
  /// What the pins have done to the particles by moving since beginStep() [J]. With Euler's
  /// schemes, the share of the forces at the end comes with the next step.
  double pinWork() const { return pin_work_; }
  /// Symplectic Euler between half kicks, with an estimate: a step of h [s] in equal sub-steps.
  SubstepReport advanceVerlet(int substeps, double h, const Drive& drive, State& state);

 private:
  void advanceEuler(double h, const Drive& drive, State& state);
  void advanceRungeKutta(double h, const Drive& drive, State& state, SubstepReport& report);
  struct PinnedParticle {
    Eigen::Index particle;
    Eigen::Vector3d before, now;  ///< m/s, in the last sub-step and in this one
  };
  void beginSubstep(const Drive& drive, const State& state);
  /// @param share  s, for which these accelerations act
  void findAccelerations(const Drive& drive, const Point& point, double share);
  /// @param share  s, for which the forces in accelerations_ act
  /// @param euler  these are all the forces of the sub-step
  void addPinWork(const Drive& drive, double share, bool euler);

  Workspace& workspace_;
  Scheme scheme_;
  Vectors accelerations_;
  std::vector<char> pinned_;  // that the next two belong to
  Vectors mobilities_;        // 1/kg per coordinate, 0 for pinned particles
  std::vector<PinnedParticle> pins_;
  double pin_work_ = 0.0;                   // J
  Vectors x_, v_, sum_x_, sum_v_, last_v_;  // not for explicit Euler
};

}  // namespace mass_spring
