#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "solvers/row_halves.h"

namespace mass_spring {

/// Collects the pairs of particles that some effect couples.
class PatternBuilder {
 public:
  void couple(std::uint32_t i, std::uint32_t j);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> sortedPairs() &&;

 private:
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs_;  // first < second
};

/// Which off-diagonal 3x3 blocks of a symmetric matrix exist: the strict upper triangle by rows.
/// Fixed for the life of a model; a block's slot is its index here.
class BlockPattern {
 public:
  BlockPattern(std::uint32_t size, PatternBuilder builder);

  std::uint32_t size() const { return rows_.size(); }
  std::size_t blocks() const { return rows_.column.size(); }
  /// Slots of row i, columns ascending and above i: [rowStart(i), rowStart(i + 1)).
  std::size_t rowStart(std::uint32_t i) const { return rows_.start[i]; }
  std::uint32_t column(std::size_t slot) const { return rows_.column[slot]; }
  const BlockRows& rows() const { return rows_; }
  const RowHalves& halves() const { return halves_; }
  /// The slot of a pair that was coupled, in either order.
  std::size_t slot(std::uint32_t i, std::uint32_t j) const;
  /// Scalars of the whole symmetric matrix.
  std::size_t nonzeros() const { return 9 * (size() + 2 * blocks()); }

 private:
  BlockRows rows_;
  RowHalves halves_;
};

}  // namespace mass_spring
