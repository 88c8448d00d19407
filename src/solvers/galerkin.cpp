#include "solvers/galerkin.h"

#include <algorithm>
#include <tuple>

#include "solvers/dispatch.h"
#include "solvers/float4.h"

namespace mass_spring {
namespace {

/// A fine block next to a particle, in the whole matrix.
struct Neighbor {
  std::uint32_t particle, block;
};

/// Per particle its neighbors of both triangles, and itself.
std::vector<std::vector<Neighbor>> neighbors(const BlockRows& rows) {
  std::vector<std::vector<Neighbor>> result(rows.size());
  for (std::uint32_t i = 0; i < rows.size(); ++i) {
    result[i].push_back({i, i});
    for (std::uint32_t s = rows.start[i]; s < rows.start[i + 1]; ++s) {
      result[i].push_back({rows.column[s], rows.size() + s});
      result[rows.column[s]].push_back({i, rows.size() + s});
    }
  }
  return result;
}

}  // namespace

LevelMatrix::LevelMatrix(BlockRows block_rows)
    : rows(std::move(block_rows)),
      blocks(kBlock * (rows.size() + rows.column.size())),
      row_sums(kBlock * rows.size()) {}

GalerkinProduct::GalerkinProduct(const BlockRows& fine, const Interpolation& interpolation,
                                 const Interpolation& restriction) {
  struct Contribution {
    std::uint32_t column, block;
    float weight;
  };
  const auto around = neighbors(fine);
  std::vector<Contribution> row;
  for (std::uint32_t coarse = 0; coarse < interpolation.coarse_size; ++coarse) {
    row.clear();
    for (std::uint32_t e = restriction.start[coarse]; e < restriction.start[coarse + 1]; ++e) {
      const auto& [i, weight] = restriction.entries[e];
      for (const Neighbor& neighbor : around[i]) {
        const std::uint32_t j = neighbor.particle;
        for (std::uint32_t f = interpolation.start[j]; f < interpolation.start[j + 1]; ++f) {
          const auto& [column, other_weight] = interpolation.entries[f];
          if (column > coarse) row.push_back({column, neighbor.block, weight * other_weight});
        }
      }
    }
    std::stable_sort(row.begin(), row.end(), [](const Contribution& a, const Contribution& b) {
      return std::tie(a.column, a.block) < std::tie(b.column, b.block);
    });
    for (std::size_t k = 0; k < row.size(); ++k) {
      const bool same_column = k > 0 && row[k].column == row[k - 1].column;
      if (same_column && row[k].block == row[k - 1].block) {
        terms_.back().weight += row[k].weight;
        continue;
      }
      if (!same_column) {
        if (k > 0) start_.push_back(static_cast<std::uint32_t>(terms_.size()));
        coarse_rows_.column.push_back(row[k].column);
      }
      terms_.push_back({row[k].block, row[k].weight});
    }
    if (!row.empty()) start_.push_back(static_cast<std::uint32_t>(terms_.size()));
    coarse_rows_.start.push_back(static_cast<std::uint32_t>(coarse_rows_.column.size()));
  }
  terms_.shrink_to_fit();
}

MASS_SPRING_DISPATCH
void GalerkinProduct::multiply(const LevelMatrix& fine, std::uint32_t begin, std::uint32_t end,
                               LevelMatrix& coarse) const {
  for (std::uint32_t slot = begin; slot < end; ++slot) {
    Float4 low = {}, high = {};  // xx xy xz yy, xz yy yz zz
    for (std::uint32_t t = start_[slot]; t < start_[slot + 1]; ++t) {
      const float* block = &fine.blocks[LevelMatrix::kBlock * terms_[t].block];
      low += load4(block) * terms_[t].weight;
      high += load4(block + 2) * terms_[t].weight;
    }
    store4(low, coarse.upper(slot));
    store4(high, coarse.upper(slot) + 2);
  }
}

MASS_SPRING_DISPATCH
void restrictDiagonal(const Interpolation& restriction, const LevelMatrix& fine,
                      LevelMatrix& coarse) {
  constexpr std::size_t kBlock = LevelMatrix::kBlock;
  for (std::uint32_t i = 0; i < coarse.size(); ++i) {
    Float4 low = {}, high = {};
    for (std::uint32_t e = restriction.start[i]; e < restriction.start[i + 1]; ++e) {
      const auto& [particle, weight] = restriction.entries[e];
      const float* const sum = &fine.row_sums[kBlock * particle];
      low += load4(sum) * weight;
      high += load4(sum + 2) * weight;
    }
    store4(low, &coarse.row_sums[kBlock * i]);
    store4(high, &coarse.row_sums[kBlock * i + 2]);
  }
  std::copy(coarse.row_sums.begin(), coarse.row_sums.end(), coarse.blocks.begin());
  for (std::uint32_t i = 0; i < coarse.size(); ++i) {
    float* const mine = coarse.diagonal(i);
    Float4 low = load4(mine), high = load4(mine + 2);
    for (std::uint32_t s = coarse.rows.start[i]; s < coarse.rows.start[i + 1]; ++s) {
      const float* const block = coarse.upper(s);
      float* const other = coarse.diagonal(coarse.rows.column[s]);
      const Float4 block_low = load4(block), block_high = load4(block + 2);
      // The two overlap: both are read before either is written.
      const Float4 other_low = load4(other) - block_low, other_high = load4(other + 2) - block_high;
      store4(other_low, other);
      store4(other_high, other + 2);
      low -= block_low;
      high -= block_high;
    }
    store4(low, mine);
    store4(high, mine + 2);
  }
}

}  // namespace mass_spring
