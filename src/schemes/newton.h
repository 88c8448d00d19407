#pragma once

#include "schemes/step_system.h"

namespace mass_spring {

/// One implicit stage of any scheme, with the velocities v at its end as unknowns:
///   x = positions + weight v,   g(v) = M (v - velocities) - weight f(x, v) = 0.
/// Implicit Euler (course notes eq. 12-13) has weight = h and the state before the step as base.
struct Stage {
  double weight;              ///< s
  double after;               ///< s, from the start of the sub-step to the end of the stage
  const Vectors& positions;   ///< m
  const Vectors& velocities;  ///< m/s
};

/// Newton's method for the stages of all implicit schemes, with a line search on the incremental
/// potential
///   Phi(v) = |v - velocities|^2_M / 2 + U(x) + weight Q(x, v) - weight F . v,
/// whose gradient is g (but for the dependence of Q on x). The matrix is the exact one, with which
/// the iteration ends quadratically. Where it turns out indefinite, compressed springs are
/// projected where the masses alone could not keep it definite. That stiffens the directions in
/// which cloth buckles (Longva et al. 2023); once it creeps, the exact matrix is made heavier
/// instead: (1 + mu) M + w D + w^2 K is that of a stage shorter by sqrt(1 + mu), which knows still
/// where the cloth wants to go. The line search lengthens steps that turn out too short. Linear
/// systems are solved only as exactly as the iteration can use (Eisenstat and Walker 1996). Ends
/// when the error left in the displacements, estimated from the last step and the rate at which
/// steps shrink, is below newton_tolerance times the mean rest length for every particle: a
/// criterion that knows no units.
class Newton {
 public:
  Newton(Workspace& workspace, const SolverOptions& options, StepSystem& system);

  /// @param v  a first guess that the root replaces; pinned columns are kept. Unconverged, it is
  ///           the best iterate; where forces overflow, not a number.
  void solve(const Stage& stage, const Drive& drive, Vectors& v, SubstepReport& report);
  /// The same, with a result that lies not above Phi at rest (v = 0 for the free): then a step of
  /// implicit Euler gains no energy, since Phi(rest) = |v_n|^2_M / 2 + U_n. Where the iteration
  /// ends above it, it starts again from rest with the directions of damping held as they are
  /// there: g is then exactly the gradient of Phi, and every step of the line search descends.
  void solveBelowRest(const Stage& stage, const Drive& drive, Vectors& v, SubstepReport& report);

 private:
  struct Potential {
    double value, noise;  // J; the rounding error in it
  };
  /// Positions, forces, g and Phi at v.
  void evaluate(const Stage& stage, const Drive& drive, const Vectors& v);
  /// From v towards the root. @return whether v is one; else it is the best iterate
  bool iterate(const Stage& stage, const Drive& drive, Vectors& v, SubstepReport& report);
  /// The same where the matrix is too far from the derivative, as it leaves out that the directions
  /// of damping turn with x: solves with the directions held, and again with those found, until
  /// they agree. @return false if they do not
  bool iterateHolding(const Stage& stage, const Drive& drive, Vectors& v, SubstepReport& report);
  /// iterate() with the directions of damping as they are at the end of a stage with velocities
  /// `held`. Then g is exactly the gradient of Phi, A its derivative, and each step descends.
  bool descend(const Stage& stage, const Drive& drive, const Vectors& held, Vectors& v,
               SubstepReport& report);
  /// delta_ = -A^-1 g with a matrix that is definite, at the iterate v.
  LinearSystem::Result solveForStep(const Stage& stage, const Drive& drive, const Vectors& v,
                                    double tolerance, SubstepReport& report);
  /// Steps along delta_. @return the share taken, 0 if there is none that helps
  double searchLine(const Stage& stage, const Drive& drive, Vectors& v);
  /// Goes on along delta_ from its end while that pays. @return the share taken, >= 1
  template <typename StepTo>
  double lengthen(double slope, const StepTo& stepTo);
  void markOverflow(Vectors& v) const;

  Workspace& workspace_;
  const Model& model_;
  SolverOptions options_;
  double length_;  // m, what newton_tolerance is relative to
  StepSystem& system_;
  Vectors x_, forces_, residual_;  // at the iterate
  Potential potential_{0.0, 0.0};
  double added_masses_ = 0.0;               // mu of the last matrix
  bool projected_ = false, crept_ = false;  // the last matrix; since the iteration began
  double residual_norm_ = 0.0;              // sqrt(g^T M^-1 g) [kg^1/2 m/s]
  Vectors right_side_, delta_, v_before_, rest_, guess_;
  bool damped_ = false;
  bool hold_damping_ = false;
  Vectors held_positions_;  // whose directions the damping takes while it is held
};

}  // namespace mass_spring
