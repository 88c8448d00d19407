#pragma once

#include <memory>
#include <vector>

#include "mass_spring_sim/state.h"
#include "solvers/block3.h"
#include "solvers/step_matrix.h"

namespace mass_spring {

/// Direct factor P A P^T = (I + L) D (I + L)^T of 3x3 blocks, ordered by approximate minimum degree
/// and analysed once per pattern. Chains and trees of particles factorise without fill, in O(n).
class SparseCholesky {
 public:
  explicit SparseCholesky(std::shared_ptr<const BlockPattern> pattern);

  /// 3x3 block products of one factorisation: what it will cost, known before it is done.
  std::size_t blockProducts() const { return block_products_; }
  /// Reserves the factor's memory; factorize() does it by itself if it must.
  void reserve();
  /// @return false if the matrix is not positive definite (or not finite)
  bool factorize(const StepMatrix& matrix);
  /// x = A^-1 b
  void solve(const Vectors& b, Vectors& x);

 private:
  std::shared_ptr<const BlockPattern> pattern_;
  std::vector<std::uint32_t> order_;     // new position -> particle
  std::vector<std::uint32_t> position_;  // particle -> new position
  // Strict upper triangle of the permuted matrix by columns: the entries of row k of its lower.
  std::vector<std::size_t> a_start_;
  std::vector<std::uint32_t> a_row_;
  std::vector<std::size_t> a_slot_;
  std::vector<std::int64_t> parent_;  // elimination tree, -1 = root
  std::vector<std::size_t> l_start_;  // columns of L
  std::size_t block_products_ = 0;

  std::vector<std::uint32_t> l_row_;
  std::vector<Block3> l_;
  std::vector<SymmetricBlock> inverse_pivot_;
  std::vector<std::size_t> l_end_;    // filled part of each column while factorising
  std::vector<Block3> work_;          // row of W = L D under way, by column
  std::vector<std::uint32_t> reach_;  // columns of that row, in the order of elimination
  std::vector<std::uint32_t> path_;
  std::vector<std::uint32_t> mark_;
  Vectors permuted_;
};

}  // namespace mass_spring
