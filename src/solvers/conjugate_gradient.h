#pragma once

#include <memory>

#include "solvers/preconditioner.h"

namespace mass_spring {

struct LinearResult {
  bool converged = false;
  std::uint32_t iterations = 0;
  double residual = 0.0;    ///< |b - A x| / |b|; 0 where b = 0
  bool indefinite = false;  ///< stopped by a direction along which the matrix is not positive
};

/// Preconditioned conjugate gradients.
class ConjugateGradient {
 public:
  ConjugateGradient(std::unique_ptr<Preconditioner> preconditioner, std::uint32_t size);

  /// Takes the matrix for the solutions to come; the first that iterates prepares the
  /// preconditioner.
  void prepare(const StepMatrix& matrix);
  /// Solves A x = b to |b - A x| <= tolerance |b|, starting from the x given.
  /// On failure x is the best iterate so far.
  LinearResult solve(const Vectors& b, double tolerance, std::uint32_t max_iterations, Vectors& x);

 private:
  /// The sum of what work(first column, columns) returns for the halves of the matrix's rows.
  template <typename Work>
  double sumOverHalves(const Work& work) const;

  std::unique_ptr<Preconditioner> preconditioner_;
  const StepMatrix* matrix_ = nullptr;
  bool prepared_ = false;  // the preconditioner, for matrix_
  Vectors r_, z_, p_, q_;
};

}  // namespace mass_spring
