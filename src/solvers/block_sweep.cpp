#include "solvers/block_sweep.h"

#include <algorithm>
#include <cmath>

#include "solvers/dispatch.h"
#include "solvers/float4.h"
#include "solvers/symmetric_block.h"

namespace mass_spring {
namespace {

constexpr std::size_t kBlock = LevelMatrix::kBlock;
// Below this many particles a second thread costs more than it saves.
constexpr std::uint32_t kLeastToSplit = 512;

}  // namespace

BlockSweep::BlockSweep(const BlockRows& rows)
    : size_(rows.size()),
      parts_(size_ < kLeastToSplit ? 1 : 2),
      split_(0),
      first_coupled_(0),
      row_end_(rows.start.begin() + 1, rows.start.end()),
      inverse_(kBlock * size_) {
  if (parts_ == 1) return;
  const std::size_t work = size_ + rows.column.size();
  while (2 * (split_ + rows.start[split_]) < work) ++split_;
  first_coupled_ = split_;
  for (std::uint32_t i = split_; i-- > 0;) {
    const auto first = rows.column.begin() + rows.start[i];
    const auto last = rows.column.begin() + rows.start[i + 1];
    row_end_[i] =
        static_cast<std::uint32_t>(std::lower_bound(first, last, split_) - rows.column.begin());
    if (row_end_[i] < rows.start[i + 1]) first_coupled_ = i;
  }
}

void BlockSweep::prepare(const LevelMatrix& matrix) {
  for (std::uint32_t i = 0; i < size_; ++i) {
    const float* d = matrix.diagonal(i);
    SymmetricBlock inverse;
    if (!SymmetricBlock{d[0], d[1], d[2], d[3], d[4], d[5]}.invert(inverse)) {
      const double size = std::abs(d[0]) + std::abs(d[3]) + std::abs(d[5]);
      inverse = SymmetricBlock::isotropic(size > 0.0 ? 1.0 / size : 0.0);
    }
    float* const to = &inverse_[kBlock * i];
    to[0] = static_cast<float>(inverse.xx), to[1] = static_cast<float>(inverse.xy);
    to[2] = static_cast<float>(inverse.xz), to[3] = static_cast<float>(inverse.yy);
    to[4] = static_cast<float>(inverse.yz), to[5] = static_cast<float>(inverse.zz);
  }
}

MASS_SPRING_DISPATCH
void BlockSweep::sweepDown(const LevelMatrix& matrix, std::uint32_t part, const float* b, float* z,
                           float* r) {
  const std::uint32_t* const column = matrix.rows.column.data();
  const float* const upper = matrix.upper(0);
  for (std::uint32_t i = end(part); i-- > begin(part);) {
    const std::uint32_t row_start = matrix.rows.start[i], row_end = row_end_[i];
    Float4 sum = load4(b + 4 * i);
    for (std::uint32_t s = row_end; s-- > row_start;) {
      sum -= Columns4(upper + kBlock * s).times(z + 4 * column[s]);
    }
    float right[4];
    store4(sum, right);
    const Float4 mine = Columns4(&inverse_[kBlock * i]).times(right);
    store4(mine, z + 4 * i);
    store4(Float4{}, r + 4 * i);
    for (std::uint32_t s = row_start; s < row_end; ++s) {
      float* const to = r + 4 * column[s];
      store4(load4(to) - Columns4(upper + kBlock * s).times(z + 4 * i), to);
    }
  }
}

MASS_SPRING_DISPATCH
double BlockSweep::sweepUp(const LevelMatrix& matrix, std::uint32_t part, const float* b, float* r,
                           float* z) {
  const std::uint32_t* const column = matrix.rows.column.data();
  const float* const upper = matrix.upper(0);
  double product = 0.0;
  for (std::uint32_t i = begin(part); i < end(part); ++i) {
    const std::uint32_t row_start = matrix.rows.start[i], row_end = row_end_[i];
    Float4 sum = load4(r + 4 * i);
    for (std::uint32_t s = row_start; s < row_end; ++s) {
      sum -= Columns4(upper + kBlock * s).times(z + 4 * column[s]);
    }
    float right[4];
    store4(sum, right);
    store4(Columns4(&inverse_[kBlock * i]).times(right), z + 4 * i);
    for (std::uint32_t s = row_start; s < row_end; ++s) {
      float* const to = r + 4 * column[s];
      store4(load4(to) - Columns4(upper + kBlock * s).times(z + 4 * i), to);
    }
    for (int k = 0; k < 3; ++k) product += static_cast<double>(b[4 * i + k]) * z[4 * i + k];
  }
  return product;
}

MASS_SPRING_DISPATCH
void BlockSweep::couple(const LevelMatrix& matrix, const float* z, float* r) const {
  for (std::uint32_t i = first_coupled_; i < split_; ++i) {
    for (std::uint32_t s = row_end_[i]; s < matrix.rows.start[i + 1]; ++s) {
      const Columns4 block(matrix.upper(s));
      const std::uint32_t j = matrix.rows.column[s];
      store4(load4(r + 4 * i) - block.times(z + 4 * j), r + 4 * i);
      store4(load4(r + 4 * j) - block.times(z + 4 * i), r + 4 * j);
    }
  }
}

}  // namespace mass_spring
