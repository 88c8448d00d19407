#include "solvers/dense_cholesky.h"

#include <algorithm>
#include <cmath>

#include "solvers/dispatch.h"

namespace mass_spring {

DenseCholesky::DenseCholesky(std::uint32_t particles)
    : n_(3 * static_cast<std::size_t>(particles)), l_(n_ * n_), x_(n_) {}

MASS_SPRING_DISPATCH
void DenseCholesky::factorize(const LevelMatrix& matrix) {
  std::fill(l_.begin(), l_.end(), 0.0);
  const auto set = [&](std::size_t i, std::size_t j, const float* b) {
    const float entries[3][3] = {{b[0], b[1], b[2]}, {b[1], b[3], b[4]}, {b[2], b[4], b[5]}};
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 3; ++c) l_[(3 * i + r) * n_ + 3 * j + c] = entries[r][c];
    }
  };
  for (std::uint32_t i = 0; i < matrix.size(); ++i) {
    set(i, i, matrix.diagonal(i));
    for (std::uint32_t s = matrix.rows.start[i]; s < matrix.rows.start[i + 1]; ++s) {
      set(matrix.rows.column[s], i, matrix.upper(s));
    }
  }
  for (std::size_t i = 0; i < n_; ++i) {
    double* const row = &l_[i * n_];
    const double before = row[i];
    for (std::size_t j = 0; j <= i; ++j) {
      const double* const other = &l_[j * n_];
      double sum = row[j];
      for (std::size_t k = 0; k < j; ++k) sum -= row[k] * other[k];
      if (j < i) {
        row[j] = sum * other[j];
      } else {
        // 1e-6: what floats leave of a pivot that should be zero.
        row[i] = sum > 1e-6 * before ? 1.0 / std::sqrt(sum) : 0.0;
      }
    }
  }
}

MASS_SPRING_DISPATCH
void DenseCholesky::solve(const float* b, float* z) {
  for (std::size_t i = 0; i < n_; ++i) {
    double sum = b[4 * (i / 3) + i % 3];
    for (std::size_t k = 0; k < i; ++k) sum -= l_[i * n_ + k] * x_[k];
    x_[i] = sum * l_[i * n_ + i];
  }
  for (std::size_t i = n_; i-- > 0;) {
    x_[i] *= l_[i * n_ + i];
    for (std::size_t k = 0; k < i; ++k) x_[k] -= l_[i * n_ + k] * x_[i];
    z[4 * (i / 3) + i % 3] = static_cast<float>(x_[i]);
  }
}

}  // namespace mass_spring
