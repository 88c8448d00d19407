#include "solvers/block_sweep.h"

#include <cmath>

#include "solvers/dispatch.h"
#include "solvers/float4.h"
#include "solvers/symmetric_block.h"

namespace mass_spring {
namespace {

constexpr std::size_t kBlock = LevelMatrix::kBlock;

}  // namespace

BlockSweep::BlockSweep(const BlockRows& rows) : halves_(rows), inverse_(kBlock * rows.size()) {}

void BlockSweep::prepare(const LevelMatrix& matrix, std::uint32_t part) {
  for (std::uint32_t i = halves_.begin(part); i < halves_.end(part); ++i) {
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
  for (std::uint32_t i = halves_.end(part); i-- > halves_.begin(part);) {
    const std::uint32_t row_start = matrix.rows.start[i], row_end = halves_.rowEnd(i);
    Float4 sum = load4(b + 4 * i);
    for (std::uint32_t s = row_end; s-- > row_start;) {
      sum -= Columns4(upper + kBlock * s).times(z + 4 * column[s]);
    }
    const Float4 mine = Columns4(&inverse_[kBlock * i]).times(sum);
    store4(mine, z + 4 * i);
    store4(Float4{}, r + 4 * i);
    for (std::uint32_t s = row_start; s < row_end; ++s) {
      float* const to = r + 4 * column[s];
      store4(load4(to) - Columns4(upper + kBlock * s).times(mine), to);
    }
  }
}

MASS_SPRING_DISPATCH
void BlockSweep::sweepUp(const LevelMatrix& matrix, std::uint32_t part, float* r, float* z) {
  const std::uint32_t* const column = matrix.rows.column.data();
  const float* const upper = matrix.upper(0);
  for (std::uint32_t i = halves_.begin(part); i < halves_.end(part); ++i) {
    const std::uint32_t row_start = matrix.rows.start[i], row_end = halves_.rowEnd(i);
    Float4 sum = {};
    for (std::uint32_t s = row_start; s < row_end; ++s) {
      sum += Columns4(upper + kBlock * s).times(z + 4 * column[s]);
    }
    const Float4 mine = Columns4(&inverse_[kBlock * i]).times(load4(r + 4 * i) - sum);
    store4(mine, z + 4 * i);
    for (std::uint32_t s = row_start; s < row_end; ++s) {
      float* const to = r + 4 * column[s];
      store4(load4(to) - Columns4(upper + kBlock * s).times(mine), to);
    }
  }
}

MASS_SPRING_DISPATCH
void BlockSweep::couple(const LevelMatrix& matrix, const float* z, float* r) const {
  for (std::uint32_t i = halves_.firstCoupled(); i < halves_.lastCoupled(); ++i) {
    for (std::uint32_t s = halves_.rowEnd(i); s < matrix.rows.start[i + 1]; ++s) {
      const Columns4 block(matrix.upper(s));
      const std::uint32_t j = matrix.rows.column[s];
      store4(load4(r + 4 * i) - block.times(z + 4 * j), r + 4 * i);
      store4(load4(r + 4 * j) - block.times(z + 4 * i), r + 4 * j);
    }
  }
}

MASS_SPRING_DISPATCH
void BlockSweep::multiply(const LevelMatrix& matrix, std::uint32_t part, const float* p,
                          float* q) const {
  const std::uint32_t* const column = matrix.rows.column.data();
  const float* const upper = matrix.upper(0);
  for (std::uint32_t i = halves_.begin(part); i < halves_.end(part); ++i) {
    store4(Columns4(&matrix.row_sums[kBlock * i]).times(p + 4 * i), q + 4 * i);
  }
  for (std::uint32_t i = halves_.begin(part); i < halves_.end(part); ++i) {
    const Float4 mine = load4(p + 4 * i);
    Float4 sum = load4(q + 4 * i);
    const std::uint32_t row_end = halves_.rowEnd(i);
    for (std::uint32_t s = matrix.rows.start[i]; s < row_end; ++s) {
      float* const to = q + 4 * column[s];
      const Float4 flow = Columns4(upper + kBlock * s).times(load4(p + 4 * column[s]) - mine);
      sum += flow;
      store4(load4(to) - flow, to);
    }
    store4(sum, q + 4 * i);
  }
}

void BlockSweep::multiplyCoupled(const LevelMatrix& matrix, const float* p, float* q) const {
  for (std::uint32_t i = halves_.firstCoupled(); i < halves_.lastCoupled(); ++i) {
    for (std::uint32_t s = halves_.rowEnd(i); s < matrix.rows.start[i + 1]; ++s) {
      const std::uint32_t j = matrix.rows.column[s];
      const Float4 flow = Columns4(matrix.upper(s)).times(load4(p + 4 * j) - load4(p + 4 * i));
      store4(load4(q + 4 * i) + flow, q + 4 * i);
      store4(load4(q + 4 * j) - flow, q + 4 * j);
    }
  }
}

}  // namespace mass_spring
