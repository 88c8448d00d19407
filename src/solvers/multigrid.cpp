#include "solvers/multigrid.h"

#include <algorithm>

#include "solvers/dispatch.h"
#include "solvers/float4.h"
#include "thread_pool.h"

namespace mass_spring {
namespace {

constexpr std::size_t kBlock = LevelMatrix::kBlock;
// Particles of the coarsest level, which a full matrix solves.
constexpr std::uint32_t kCoarsest = 36;

BlockRows rowsOf(const BlockPattern& pattern) {
  BlockRows rows;
  for (std::uint32_t i = 0; i < pattern.size(); ++i) {
    rows.start.push_back(static_cast<std::uint32_t>(pattern.rowStart(i + 1)));
  }
  for (std::size_t s = 0; s < pattern.blocks(); ++s) rows.column.push_back(pattern.column(s));
  return rows;
}

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

Multigrid::Level::Level(BlockRows rows)
    : matrix(std::move(rows)),
      sweep(matrix.rows),
      b(4 * matrix.size()),
      z(4 * matrix.size()),
      r(4 * matrix.size()) {}

Multigrid::Multigrid(const Model& model)
    : threads_(*model.threads), row_sums_(model.pattern->size()) {
  RestShape shape(model);
  levels_.emplace_back(rowsOf(*model.pattern));
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
  const double scale = 1.0 / largest;
  std::copy(matrix.diagonal().begin(), matrix.diagonal().end(), row_sums_.begin());
  for (std::uint32_t i = 0; i < finest.size(); ++i) {
    store(matrix.diagonal()[i], scale, finest.diagonal(i));
    for (std::uint32_t s = finest.rows.start[i]; s < finest.rows.start[i + 1]; ++s) {
      const SymmetricBlock& block = matrix.upper()[s];
      store(block, scale, finest.upper(s));
      row_sums_[i] += block;
      row_sums_[finest.rows.column[s]] += block;
    }
  }
  for (std::uint32_t i = 0; i < finest.size(); ++i) {
    store(row_sums_[i], scale, &finest.row_sums[kBlock * i]);
  }
  return true;
}

bool Multigrid::prepare(const StepMatrix& matrix) {
  if (!takeMatrix(matrix)) return false;
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    Level& level = levels_[l];
    level.sweep.prepare(level.matrix);
    if (!level.product) break;
    LevelMatrix& coarse = levels_[l + 1].matrix;
    const auto blocks = static_cast<std::uint32_t>(coarse.rows.column.size());
    const std::uint32_t parts = level.sweep.parts();
    threads_.run(parts, [&](std::uint32_t part) {
      level.product->multiply(level.matrix, blocks / parts * part,
                              part + 1 == parts ? blocks : blocks / parts, coarse);
    });
    restrictDiagonal(level.restriction, level.matrix, coarse);
  }
  if (coarsest_) coarsest_->factorize(levels_.back().matrix);
  return true;
}

double Multigrid::cycle(std::size_t l) {
  Level& level = levels_[l];
  const bool last = l + 1 == levels_.size();
  if (last && coarsest_) {
    coarsest_->solve(level.b.data(), level.z.data());
    return 0.0;
  }
  const std::uint32_t parts = level.sweep.parts();
  float* const b = level.b.data();
  float* const z = level.z.data();
  float* const r = level.r.data();
  threads_.run(parts,
               [&](std::uint32_t part) { level.sweep.sweepDown(level.matrix, part, b, z, r); });
  level.sweep.couple(level.matrix, z, r);
  if (!last) {
    Level& coarse = levels_[l + 1];
    const std::uint32_t half = parts == 1 ? coarse.matrix.size() : coarse.matrix.size() / 2;
    threads_.run(parts, [&](std::uint32_t part) {
      gather(level.restriction, r, part * half, part + 1 == parts ? coarse.matrix.size() : half,
             coarse.b.data());
    });
    cycle(l + 1);
  }
  if (last) {
    level.r = level.b;
  } else {
    threads_.run(parts, [&](std::uint32_t part) {
      correct(level.interpolation, levels_[l + 1].z.data(), level.sweep.begin(part),
              level.sweep.end(part), b, z, r);
    });
  }
  level.sweep.couple(level.matrix, z, r);
  double products[2] = {0.0, 0.0};
  threads_.run(parts, [&](std::uint32_t part) {
    products[part] = level.sweep.sweepUp(level.matrix, part, b, r, z);
  });
  return products[0] + products[1];
}

double Multigrid::apply(const Vectors& r, Vectors& z) {
  Level& finest = levels_.front();
  // Residuals of any size fit into floats once they are scaled.
  const double size = r.cwiseAbs().maxCoeff();
  const double scale = size > 0.0 ? 1.0 / size : 1.0;
  for (Eigen::Index i = 0; i < r.cols(); ++i) {
    for (int k = 0; k < 3; ++k) {
      finest.b[4 * i + k] = static_cast<float>(scale * r(k, i));
    }
  }
  cycle(0);
  for (Eigen::Index i = 0; i < r.cols(); ++i) {
    for (int k = 0; k < 3; ++k) z(k, i) = finest.z[4 * i + k];
  }
  return r.cwiseProduct(z).sum();
}

}  // namespace mass_spring
