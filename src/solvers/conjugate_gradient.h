#pragma once

#include <memory>

#include "solvers/incomplete_cholesky.h"
#include "solvers/step_matrix.h"

namespace mass_spring {

struct LinearResult {
  bool converged = false;
  std::uint32_t iterations = 0;
  double residual = 0.0;    ///< |b - A x| / |b|; 0 where b = 0
  bool indefinite = false;  ///< stopped by a direction along which the matrix is not positive
};

/// Conjugate gradients preconditioned by a block incomplete Cholesky factor.
class ConjugateGradient {
 public:
  explicit ConjugateGradient(std::shared_ptr<const BlockPattern> pattern);

  /// Takes the matrix for the solutions to come; the first that iterates factorises it.
  void prepare(const StepMatrix& matrix);
  /// Solves A x = b to |b - A x| <= tolerance |b|, starting from the x given.
  /// On failure x is the best iterate so far.
  LinearResult solve(const Vectors& b, double tolerance, std::uint32_t max_iterations, Vectors& x);

 private:
  IncompleteCholesky preconditioner_;
  const StepMatrix* matrix_ = nullptr;
  bool factorized_ = false;
  Vectors r_, z_, p_, q_;
};

}  // namespace mass_spring
