#pragma once

#include <memory>
#include <vector>

#include "solvers/block3.h"
#include "solvers/direct_solver.h"

namespace mass_spring {

/// Direct factor P A P^T = L L^T of 3x3 blocks in any order of elimination. Its fill
/// stays within the band that the order makes of the matrix, so that it serves as the banded solver
/// too: ropes factorize in O(n), as chains and trees do in order of minimum degree, without fill.
/// A kernel of its own for bands, without indices, gained nothing: 0.42 against 0.37 ms for a
/// rope of 10,000 links.
class SparseCholesky : public DirectSolver {
 public:
  /// @param order  the particle at each position, see ordering.h
  SparseCholesky(std::shared_ptr<const BlockPattern> pattern, std::vector<std::uint32_t> order);

  double blockProducts() const override { return block_products_; }
  void reserve() override;
  bool factorize(const StepMatrix& matrix) override;
  void solve(const Vectors& b, Vectors& x) override;

 private:
  // What the virtual functions call: those cannot be compiled for several processors.
  bool eliminate(const StepMatrix& matrix);
  void substitute(const Vectors& b, Vectors& x);

  std::shared_ptr<const BlockPattern> pattern_;
  std::vector<std::uint32_t> order_;     // new position -> particle
  std::vector<std::uint32_t> position_;  // particle -> new position
  // Strict upper triangle of the permuted matrix by columns: the entries of row k of its lower.
  std::vector<std::size_t> a_start_;
  std::vector<std::uint32_t> a_row_;
  std::vector<std::size_t> a_slot_;
  std::vector<std::int64_t> parent_;  // elimination tree, -1 = root
  std::vector<std::size_t> l_start_;  // columns of L
  double block_products_ = 0.0;

  std::vector<std::uint32_t> l_row_;
  std::vector<Block3> l_;
  std::vector<PivotBlock> pivot_;
  std::vector<std::size_t> l_end_;    // filled part of each column while factorizing
  std::vector<Block3> work_;          // row of L under way, by column
  std::vector<std::uint32_t> reach_;  // columns of that row, in the order of elimination
  std::vector<std::uint32_t> path_;
  std::vector<std::uint32_t> mark_;
  Vectors permuted_;
};

}  // namespace mass_spring
