#pragma once

#include <vector>

#include "solvers/galerkin.h"

namespace mass_spring {

/// The coarsest level of a multigrid, solved at once: A = L L^T as a full matrix.
class DenseCholesky {
 public:
  explicit DenseCholesky(std::uint32_t particles);
  /// A pivot that is not positive loses its unknown, which then stays zero.
  void factorize(const LevelMatrix& matrix);
  /// z = A^-1 b, four floats per particle.
  void solve(const float* b, float* z);

 private:
  std::size_t n_;
  std::vector<double> l_;  // lower triangle by rows; on the diagonal the inverse, or 0
  std::vector<double> x_;
};

}  // namespace mass_spring
