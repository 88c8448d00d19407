#pragma once

#include <memory>
#include <optional>

#include "mass_spring_sim/scheme.h"
#include "solvers/conjugate_gradient.h"
#include "solvers/sparse_cholesky.h"
#include "solvers/step_matrix.h"

namespace mass_spring {

/// Solves with the step matrix by the solver asked for. `auto` takes the direct factor where that
/// costs less than conjugate gradients would, and where those do not reach their tolerance.
class LinearSystem {
 public:
  LinearSystem(std::shared_ptr<const BlockPattern> pattern, const SolverOptions& options);

  struct Result {
    bool converged = false;
    std::uint32_t iterations = 0;
    std::uint32_t factorizations = 0;  ///< direct ones
    double residual = 0.0;             ///< |b - A x| / |b|
    bool indefinite = false;           ///< the matrix is not positive definite
  };
  /// Solves A x = b, from the x given where that helps. On failure x is the best there is.
  Result solve(const StepMatrix& matrix, const Vectors& b, Vectors& x);

  bool direct() const { return direct_; }

 private:
  bool solveDirectly(const StepMatrix& matrix, const Vectors& b, Vectors& x, Result& result);

  SolverOptions options_;
  bool direct_;
  std::optional<SparseCholesky> cholesky_;
  std::optional<ConjugateGradient> conjugate_gradient_;
  Vectors residual_, correction_;
};

}  // namespace mass_spring
