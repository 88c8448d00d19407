#pragma once

#include "solvers/step_matrix.h"

namespace mass_spring {

/// An approximate inverse of a symmetric positive definite matrix, itself symmetric and positive
/// definite (but for rounding).
class Preconditioner {
 public:
  virtual ~Preconditioner() = default;
  /// @return false if the matrix cannot be positive definite: one of its diagonal blocks is not
  virtual bool prepare(const StepMatrix& matrix) = 0;
  /// z = (approximately) A^-1 r. @return r . z
  virtual double apply(const Vectors& r, Vectors& z) = 0;
};

}  // namespace mass_spring
