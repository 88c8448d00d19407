#pragma once

#include <array>

#include "schemes/step_system.h"

namespace mass_spring {

/// A Rosenbrock method: linear systems instead of nonlinear ones. In the form of Hairer and Wanner
/// (1996, IV.7), for y' = F(y) with J = dF/dy at the start of the step:
///   (I / (gamma h) - J) U_i = F(t_n + alpha_i h, y_n + sum_j<i a_ij U_j) + sum_j<i (c_ij / h) U_j
///                             + gamma_i h dF/dt,
///   y_{n+1} = y_n + sum_i m_i U_i, estimate sum_i e_i U_i.
struct RosenbrockTable {
  int stages;
  double gamma;
  std::array<std::array<double, 2>, 3> a, c;
  std::array<double, 3> m, error;
  std::array<double, 3> alpha, gamma_rate;  ///< alpha_i, gamma_i
  /// Is J the exact derivative? If not, the step matrix serves as it is (projected where needed,
  /// without the damping's dependence on x), as the course notes have it.
  bool exact;
};

/// The linearly implicit schemes: linear_implicit_euler (course notes eq. 16/19) and ros3, both
/// as tables over one loop.
class Rosenbrock {
 public:
  /// For options.scheme and, as a budget may ask for it, for kLinearImplicitEuler.
  Rosenbrock(Workspace& workspace, const SolverOptions& options, StepSystem& system);

  /// Advances positions and velocities by h [s].
  /// @param scheme  kLinearImplicitEuler or kRos3
  SubstepReport advance(Scheme scheme, double h, const Drive& drive, State& state);

 private:
  void advance(const RosenbrockTable& table, double h, const Drive& drive, State& state,
               SubstepReport& report);
  /// How fast the forces change where nothing moves.
  void findForcesRate(double h, const Drive& drive, const State& state);
  /// A u = right_side_ for the free particles, from the u given; its pinned columns are given.
  void solve(const Drive& drive, Vectors& u, SubstepReport& report);
  /// The same with the exact derivatives at the state, to which the step matrix only leads.
  void solveExactly(double w, const Drive& drive, const State& state, Vectors& u,
                    SubstepReport& report);

  Workspace& workspace_;
  const Model& model_;
  SolverOptions options_;
  StepSystem& system_;
  Vectors x_, v_, rate_, right_side_;  // of a stage
  Vectors u_, product_, change_, still_;
  Vectors forces_rate_;           // N/s, where forces depend on time
  std::array<Vectors, 3> p_, q_;  // U_i of positions and velocities
};

}  // namespace mass_spring
