#pragma once

#include <memory>
#include <optional>

#include "mass_spring_sim/scheme.h"
#include "solvers/conjugate_gradient.h"
#include "solvers/direct_solver.h"
#include "solvers/step_matrix.h"

namespace mass_spring {

class Workspace;

/// Solves with the step matrix by the solver asked for. `auto` takes the direct factor where that
/// costs less than conjugate gradients would, and where those do not reach their tolerance. A
/// factor does not know of ties: where there are some, it leads conjugate gradients, which are as
/// many as there are ties at most.
class LinearSystem {
 public:
  LinearSystem(Workspace& workspace, const SolverOptions& options);

  struct Result {
    bool converged = false;
    std::uint32_t iterations = 0;
    std::uint32_t factorizations = 0;  ///< direct ones
    double residual = 0.0;             ///< |b - A x| / |b|
    bool indefinite = false;           ///< the matrix is not positive definite
  };
  /// Takes the matrix for the solutions to come; it has to stay as it is until the last of them.
  /// What that costs (a factor, a preconditioner) is spent by the first solution that needs it, and
  /// counted there.
  void prepare(const StepMatrix& matrix);
  /// Solves A x = b to |b - A x| <= tolerance |b| with the matrix of prepare(), from the x given
  /// where that helps. On failure x is the best there is.
  Result solve(const Vectors& b, double tolerance, Vectors& x);
  /// prepare() and solve()
  Result solve(const StepMatrix& matrix, const Vectors& b, double tolerance, Vectors& x);

  /// Forgets what earlier matrices taught, so that a run that starts anew repeats itself.
  void restart();

  bool direct() const { return direct_; }

 private:
  void solveDirectly(const Vectors& b, double tolerance, Vectors& x, Result& result);
  void solveByFactor(const Vectors& b, double tolerance, Vectors& x, Result& result);

  SolverOptions options_;
  bool direct_;  // by choice, for every matrix
  // Matrices that conjugate gradients failed on come in series. After a failure the next ones go
  // to the direct factor at once; after another one, twice as many.
  std::uint32_t most_iterations_ = 0;
  std::uint32_t direct_for_ = 0, direct_for_next_ = 1;  // matrices
  const StepMatrix* matrix_ = nullptr;
  bool factorized_ = false;  // matrix_, by direct_solver_
  std::unique_ptr<DirectSolver> direct_solver_;
  std::optional<ConjugateGradient> conjugate_gradient_;
  std::optional<ConjugateGradient> led_by_factor_;  // only where there may be ties
  Vectors residual_, correction_;
};

}  // namespace mass_spring
