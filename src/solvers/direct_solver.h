#pragma once

#include <memory>

#include "mass_spring_sim/scheme.h"
#include "mass_spring_sim/state.h"
#include "solvers/step_matrix.h"

namespace mass_spring {

/// A factor of the step matrix: analyzed once per pattern, factorized for each matrix, solved with
/// for each right-hand side.
class DirectSolver {
 public:
  virtual ~DirectSolver() = default;

  /// 3x3 block products of one factorization: what it will cost, known before it is done.
  virtual double blockProducts() const = 0;
  /// Takes the factor's memory; factorize() does it by itself if it must.
  virtual void reserve() = 0;
  /// @return false if the matrix is not positive definite (or not finite)
  virtual bool factorize(const StepMatrix& matrix) = 0;
  /// x = A^-1 b
  virtual void solve(const Vectors& b, Vectors& x) = 0;
};

/// The direct solver that is called for: kBanded by a band, kCholesky by the sparse factor that is
/// fastest on this pattern, any other by whichever of them costs less.
std::unique_ptr<DirectSolver> makeDirectSolver(LinearSolver solver,
                                               std::shared_ptr<const BlockPattern> pattern);

}  // namespace mass_spring
