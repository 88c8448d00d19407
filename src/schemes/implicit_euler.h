#pragma once

#include <memory>

#include "effects/effect.h"
#include "mass_spring_sim/model.h"
#include "schemes/drive.h"
#include "solvers/linear_system.h"

namespace mass_spring {

/// Implicit Euler with the new velocities as unknowns (course notes eq. 12-13), with the residual
///   g(v) = M (v - v_n) - h f(x_n + h v, v).
/// Linearly implicit: one linear system, eq. 16/19. Fully implicit: Newton's method with a line
/// search on the incremental potential
///   Phi(v) = |v - v_n|^2_M / 2 + U(x_n + h v) + h Q(x_n + h v, v),
/// whose gradient is g (but for the dependence of Q on x).
class ImplicitEuler {
 public:
  ImplicitEuler(const Model& model, const SolverOptions& options);

  /// Eq. 19: (M + h D + h^2 K) v = M v_n + h f_n + h D v_n, from the start v_n as the notes say.
  SubstepReport advanceLinearly(double h, const Drive& drive, State& state);
  /// Newton to the tolerance of the options. Unconverged, the state is still the best iterate.
  SubstepReport advance(double h, const Drive& drive, State& state);

  std::size_t matrixNonzeros() const { return matrix_.pattern().nonzeros(); }

 private:
  struct Potential {
    double value, noise;  // J; the rounding error in it
  };
  /// Positions, forces, g and its norm at the iterate v_.
  void evaluate(double h, const Drive& drive, const State& state);
  /// Phi at the iterate v_, x_.
  Potential potential(double h, const Drive& drive, const State& state);
  /// @param from_rest  start at v = 0 and only ever lower Phi
  SubstepReport newton(double h, const Drive& drive, const State& state, bool from_rest);
  /// delta_ = -A^-1 g. Tries the exact matrix if told so; where it turns out indefinite, projects
  /// and clears `exact`.
  LinearSystem::Result solveForStep(double h, const Drive& drive, bool& exact,
                                    SubstepReport& report);
  bool searchLine(double h, const Drive& drive, const State& state, bool strict);
  void prescribeVelocities(double h, const Drive& drive, const State& state, Vectors& v) const;
  void assemble(double h, const Vectors& x, Projection projection, SubstepReport& report);
  LinearSystem::Result solve(SubstepReport& report, Vectors& x);

  const Model& model_;
  SolverOptions options_;
  double length_;  // m, what newton_tolerance is relative to
  StepMatrix matrix_;
  LinearSystem system_;
  Vectors v_, x_, forces_;         // the iterate
  Vectors residual_, right_side_;  // g at the iterate; what is solved for
  Vectors delta_;
  Vectors v_before_;            // the iterate to come back to
  double residual_norm_ = 0.0;  // sqrt(g^T M^-1 g) [kg^1/2 m/s]
};

}  // namespace mass_spring
