#pragma once

#include <memory>
#include <vector>

#include "mass_spring_sim/state.h"
#include "solvers/block3.h"
#include "solvers/step_matrix.h"

namespace mass_spring {

/// Block incomplete factor without fill, A ~ (I + L) D (I + L)^T, in the particles' own order.
/// Where a pivot loses its sign, the factorisation starts anew with a heavier diagonal; the last
/// resort, all weight on the diagonal, is block Jacobi.
class IncompleteCholesky {
 public:
  explicit IncompleteCholesky(std::shared_ptr<const BlockPattern> pattern);

  /// @return false if not even the diagonal blocks are positive definite
  bool factorize(const StepMatrix& matrix);
  /// z = (approximately) A^-1 r
  void apply(const Vectors& r, Vectors& z) const;

 private:
  /// L_ij needs L_ik and L_jk for each k < j that both rows have; found once.
  struct Update {
    std::uint32_t ik, jk;  // entries of lower_
  };
  bool factorize(const StepMatrix& matrix, double shift);

  std::shared_ptr<const BlockPattern> pattern_;
  // Strict lower triangle by rows: entry e of row i holds the block (i, column_[e]).
  std::vector<std::uint32_t> row_start_, column_, slot_;
  std::vector<std::uint32_t> update_start_;  // per entry
  std::vector<Update> updates_;
  std::vector<Block3> lower_;
  std::vector<Block3> scaled_;  // L_ij D_j of the row under way, by entry
  std::vector<SymmetricBlock> inverse_pivot_;
};

}  // namespace mass_spring
