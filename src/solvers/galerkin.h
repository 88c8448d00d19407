#pragma once

#include <cstddef>

#include "solvers/block_rows.h"
#include "solvers/interpolation.h"

namespace mass_spring {

/// The matrix of one level of a multigrid in floats, six per block (xx xy xz yy yz zz): weights
/// that are common to the three coordinates keep every block symmetric.
struct LevelMatrix {
  static constexpr std::size_t kBlock = 6;
  BlockRows rows;
  std::vector<float> blocks;  ///< those of the diagonal, then the upper ones in the order of rows
  /// Per particle the sum of the blocks of its whole row, which is what moving all particles alike
  /// meets: the mass, and pins. As a difference of large stiffnesses floats would lose it.
  std::vector<float> row_sums;

  explicit LevelMatrix(BlockRows block_rows);
  std::uint32_t size() const { return rows.size(); }
  float* diagonal(std::size_t i) { return &blocks[kBlock * i]; }
  const float* diagonal(std::size_t i) const { return &blocks[kBlock * i]; }
  float* upper(std::size_t slot) { return &blocks[kBlock * (size() + slot)]; }
  const float* upper(std::size_t slot) const { return &blocks[kBlock * (size() + slot)]; }
};

/// The coarse matrix P^T A P for an interpolation P, by lists of blocks that are found once.
class GalerkinProduct {
 public:
  GalerkinProduct(const BlockRows& fine, const Interpolation& interpolation,
                  const Interpolation& restriction);

  const BlockRows& coarseRows() const { return coarse_rows_; }
  /// The upper blocks [begin, end) of the coarse matrix.
  void multiply(const LevelMatrix& fine, std::uint32_t begin, std::uint32_t end,
                LevelMatrix& coarse) const;

 private:
  /// A block of the fine matrix, by its place in `blocks`, that goes into a coarse one.
  struct Term {
    std::uint32_t block;
    float weight;
  };
  BlockRows coarse_rows_;
  std::vector<std::uint32_t> start_{0};  // of each coarse upper block's terms
  std::vector<Term> terms_;
};

/// Row sums by the restriction, then the diagonal as what the upper blocks leave of them.
void restrictDiagonal(const Interpolation& restriction, const LevelMatrix& fine,
                      LevelMatrix& coarse);

}  // namespace mass_spring
