#pragma once

#include "mass_spring_sim/model.h"
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
  ExplicitScheme(const Model& model, Scheme scheme);
  /// Advances positions and velocities by h [s].
  SubstepReport advance(double h, const Drive& drive, State& state);
  /// Symplectic Euler between half kicks, with an estimate: a step of h [s] in equal sub-steps.
  SubstepReport advanceVerlet(int substeps, double h, const Drive& drive, State& state);

 private:
  void advanceEuler(double h, const Drive& drive, State& state);
  void advanceRungeKutta(double h, const Drive& drive, State& state, SubstepReport& report);
  void findMobilities(const Drive& drive);
  void findAccelerations(const Drive& drive, const Vectors& positions, const Vectors& velocities);

  const Model& model_;
  Scheme scheme_;
  Vectors accelerations_;
  Vectors mobilities_;                      // 1/kg per coordinate, 0 for pinned particles
  Vectors x_, v_, sum_x_, sum_v_, last_v_;  // not for explicit Euler
};

}  // namespace mass_spring
