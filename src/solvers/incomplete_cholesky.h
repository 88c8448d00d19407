#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "mass_spring_sim/state.h"
#include "solvers/block3.h"
#include "solvers/preconditioner.h"

namespace mass_spring {

/// Block incomplete factor A ~ (I + L) D (I + L)^T in the particles' own order. L has the blocks of
/// A and those that its elimination fills in directly (level 1), which for a cloth costs two thirds
/// more blocks and saves two fifths of the iterations. Factorized in double.
/// Where a pivot loses its sign, the factorization starts anew with a heavier diagonal; the last
/// resort, all weight on the diagonal, is block Jacobi.
class IncompleteCholesky : public Preconditioner {
 public:
  explicit IncompleteCholesky(std::shared_ptr<const BlockPattern> pattern);

  bool prepare(const StepMatrix& matrix) override;
  void apply(const FloatVectors& r, FloatVectors& z, FloatVectors& work) override;

 private:
  /// L_ij needs L_ik and L_jk for each k < j that both rows have; found once.
  struct Update {
    std::uint32_t ik, jk;  // entries of lower_
  };
  /// Nine floats by columns. A column is read as four: the last belongs to the next one, and what
  /// comes of it in the fourth place of a result is never used.
  static constexpr std::size_t kBlock = 9;
  static void multiplySubtract(const float* block, const float* x, Eigen::Array4f& y) {
    using Column = Eigen::Map<const Eigen::Array4f>;
    y -= Column(block) * x[0] + Column(block + 3) * x[1] + Column(block + 6) * x[2];
  }
  void findEntries();
  void findUpdates();
  void findColumns();
  bool factorize(const StepMatrix& matrix, double shift);
  void substitute(const FloatVectors& r, FloatVectors& z) const;

  std::shared_ptr<const BlockPattern> pattern_;
  // Strict lower triangle by rows: entry e of row i holds the block (i, column_[e]).
  std::vector<std::uint32_t> row_start_, column_;
  std::vector<std::size_t> slot_;            // of A; kFill where A has no block
  std::vector<std::uint32_t> update_start_;  // per entry
  std::vector<Update> updates_;
  std::vector<Block3> lower_;
  std::vector<Block3> scaled_;  // L_ij D_j
  std::vector<SymmetricBlock> inverse_pivot_;
  // The same by columns: place u of column j holds the block (row_[u], j), which is entry
  // entry_[u].
  std::vector<std::uint32_t> column_start_, row_, entry_;
  std::vector<float> forward_, backward_;  // L by rows; L^T by its rows, the columns of L
};

}  // namespace mass_spring
