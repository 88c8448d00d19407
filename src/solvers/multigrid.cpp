#include "solvers/multigrid.h"

#include <algorithm>

#include "solvers/dispatch.h"
#include "solvers/float4.h"
#include "thread_pool.h"

namespace mass_spring {
namespace {

// Particles of the coarsest level, which a full matrix solves.
constexpr std::uint32_t kCoarsest = 36;

/// to_i = sum of the weighted from, for i in [begin, end)
MASS_SPRING_DISPATCH
void gather(const Interpolation& weights, const float* from, std::uint32_t begin, std::uint32_t end,
            float* to) {
  for (std::uint32_t i = begin; i < end; ++i) {
    Float4 sum = {};
    for (std::uint32_t e = weights.start[i]; e < weights.start[i + 1]; ++e) {
      sum += load4(from + 4 * weights.entries[e].particle) * weights.entries[e].weight;
    }
    store4(sum, to + 4 * i);
  }
}

/// The same added to what is there; r starts anew from b.
MASS_SPRING_DISPATCH
void correct(const Interpolation& weights, const float* from, std::uint32_t begin,
             std::uint32_t end, const float* b, float* z, float* r) {
  for (std::uint32_t i = begin; i < end; ++i) {
    Float4 sum = load4(z + 4 * i);
    for (std::uint32_t e = weights.start[i]; e < weights.start[i + 1]; ++e) {
      sum += load4(from + 4 * weights.entries[e].particle) * weights.entries[e].weight;
    }
    store4(sum, z + 4 * i);
    store4(load4(b + 4 * i), r + 4 * i);
  }
}

void store(const SymmetricBlock& block, double scale, float* to) {
  to[0] = static_cast<float>(scale * block.xx), to[1] = static_cast<float>(scale * block.xy);
  to[2] = static_cast<float>(scale * block.xz), to[3] = static_cast<float>(scale * block.yy);
  to[4] = static_cast<float>(scale * block.yz), to[5] = static_cast<float>(scale * block.zz);
}

}  // namespace

Multigrid::Level::Level(BlockRows block_rows) : matrix(std::move(block_rows)), sweep(matrix.rows) {}

Multigrid::Multigrid(const Model& model, ThreadPool& threads)
    : threads_(threads), row_sums_(model.pattern->size()) {
  RestShape shape(model);
  levels_.emplace_back(model.pattern->rows());
  while (levels_.back().matrix.size() > kCoarsest) {
    Level& fine = levels_.back();
    Interpolation interpolation = shape.coarsen();
    // Nothing is left to couple, or thinning out gets nowhere: then there is no coarser level.
    if (interpolation.coarse_size == 0 || interpolation.coarse_size > 0.9 * fine.matrix.size()) {
      break;
    }
    fine.restriction = transposed(interpolation);
    fine.interpolation = std::move(interpolation);
    fine.product.emplace(fine.matrix.rows, fine.interpolation, fine.restriction);
    levels_.emplace_back(fine.product->coarseRows());
    Level& coarse = levels_.back();
    for (auto* vectors : {&coarse.b, &coarse.z, &coarse.r})
      vectors->resize(4 * coarse.matrix.size());
  }
  if (levels_.back().matrix.size() <= kCoarsest) coarsest_.emplace(levels_.back().matrix.size());
}

bool Multigrid::takeMatrix(const StepMatrix& matrix) {
  LevelMatrix& finest = levels_.front().matrix;
  double largest = 0.0;
  SymmetricBlock inverse;
  for (const SymmetricBlock& d : matrix.diagonal()) {
    if (!d.invert(inverse)) return false;
    largest = std::max(largest, d.xx + d.yy + d.zz);
  }
  // Floats end at 1e38.
  unit_ = largest;
  const double scale = 1.0 / unit_;
  const auto take = [&](std::uint32_t row, std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t s = begin; s < end; ++s) {
      const SymmetricBlock& block = matrix.upper()[s];
      store(block, scale, finest.upper(s));
      row_sums_[row] += block;
      row_sums_[finest.rows.column[s]] += block;
    }
  };
  const RowHalves& halves = levels_.front().sweep.halves();
  threads_.run(halves.parts(), [&](std::uint32_t part) {
    const std::uint32_t begin = halves.begin(part), end = halves.end(part);
    for (std::uint32_t i = begin; i < end; ++i) row_sums_[i] = matrix.diagonal()[i];
    for (std::uint32_t i = begin; i < end; ++i) {
      store(matrix.diagonal()[i], scale, finest.diagonal(i));
      take(i, finest.rows.start[i], halves.rowEnd(i));
    }
  });
  for (std::uint32_t i = halves.firstCoupled(); i < halves.lastCoupled(); ++i) {
    take(i, halves.rowEnd(i), finest.rows.start[i + 1]);
  }
  for (std::uint32_t i = 0; i < finest.size(); ++i) {
    store(row_sums_[i], scale, &finest.row_sums[LevelMatrix::kBlock * i]);
  }
  return true;
}

bool Multigrid::prepare(const StepMatrix& matrix) {
  if (!takeMatrix(matrix)) return false;
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    Level& level = levels_[l];
    const std::uint32_t parts = level.sweep.halves().parts();
    threads_.run(parts, [&](std::uint32_t part) { level.sweep.prepare(level.matrix, part); });
    if (!level.product) break;
    LevelMatrix& coarse = levels_[l + 1].matrix;
    const auto blocks = static_cast<std::uint32_t>(coarse.rows.column.size());
    threads_.run(parts, [&](std::uint32_t part) {
      level.product->multiply(level.matrix, blocks / parts * part,
                              part + 1 == parts ? blocks : blocks / parts, coarse);
    });
    restrictDiagonal(level.restriction, level.matrix, coarse);
  }
  if (coarsest_) coarsest_->factorize(levels_.back().matrix);
  return true;
}

void Multigrid::cycle(std::size_t l, const float* b, float* z, float* r) {
  Level& level = levels_[l];
  const bool last = l + 1 == levels_.size();
  if (last && coarsest_) {
    coarsest_->solve(b, z);
    return;
  }
  const RowHalves& halves = level.sweep.halves();
  const std::uint32_t parts = halves.parts();
  threads_.run(parts,
               [&](std::uint32_t part) { level.sweep.sweepDown(level.matrix, part, b, z, r); });
  level.sweep.couple(level.matrix, z, r);
  if (last) {
    std::copy(b, b + 4 * level.matrix.size(), r);
  } else {
    Level& coarse = levels_[l + 1];
    const std::uint32_t half = parts == 1 ? coarse.matrix.size() : coarse.matrix.size() / 2;
    threads_.run(parts, [&](std::uint32_t part) {
      gather(level.restriction, r, part * half, part + 1 == parts ? coarse.matrix.size() : half,
             coarse.b.data());
    });
    cycle(l + 1, coarse.b.data(), coarse.z.data(), coarse.r.data());
    threads_.run(parts, [&](std::uint32_t part) {
      correct(level.interpolation, coarse.z.data(), halves.begin(part), halves.end(part), b, z, r);
    });
  }
  level.sweep.couple(level.matrix, z, r);
  threads_.run(parts, [&](std::uint32_t part) { level.sweep.sweepUp(level.matrix, part, r, z); });
}

void Multigrid::apply(const FloatVectors& r, FloatVectors& z, FloatVectors& work) {
  cycle(0, r.data(), z.data(), work.data());
}

double Multigrid::multiply(const FloatVectors& p, FloatVectors& q) const {
  const LevelMatrix& finest = levels_.front().matrix;
  const BlockSweep& sweep = levels_.front().sweep;
  threads_.run(sweep.halves().parts(),
               [&](std::uint32_t part) { sweep.multiply(finest, part, p.data(), q.data()); });
  sweep.multiplyCoupled(finest, p.data(), q.data());
  return unit_;
}

}  // namespace mass_spring
