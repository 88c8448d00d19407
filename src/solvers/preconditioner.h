#pragma once

#include "solvers/step_matrix.h"

namespace mass_spring {

/// Three coordinates, and a fourth float that fills up the sixteen bytes and means nothing.
using FloatVectors = Eigen::Matrix<float, 4, Eigen::Dynamic>;

/// An approximate inverse of a symmetric positive definite matrix A, itself symmetric and positive
/// definite (but for rounding), in floats: it need not be exact, and half the bytes stream in half
/// the time.
class Preconditioner {
 public:
  virtual ~Preconditioner() = default;
  /// @return false if the matrix cannot be positive definite: one of its diagonal blocks is not
  virtual bool prepare(const StepMatrix& matrix) = 0;
  /// z = (approximately) A^-1 r but for a positive factor, the same for every r of one matrix.
  /// @param work  of the same size, left with anything
  virtual void apply(const FloatVectors& r, FloatVectors& z, FloatVectors& work) = 0;
  /// Whether it can multiply, from a copy of the matrix in floats.
  virtual bool multiplies() const { return false; }
  /// q = A p / c. Each block's rounding is like that of a spring's stiffness, and differences are
  /// taken before they are multiplied.
  /// @return c > 0
  virtual double multiply(const FloatVectors& p, FloatVectors& q) const {
    static_cast<void>(p), static_cast<void>(q);
    return 1.0;
  }
};

}  // namespace mass_spring
