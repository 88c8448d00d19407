#pragma once

#include "solvers/block_rows.h"

namespace mass_spring {

/// The rows of a symmetric matrix in two parts of about equal work, for two threads. Each part has
/// the blocks whose row and column are both its own; those between the parts are left to one thread
/// alone, and are few where neighbors have near numbers. A small matrix is one part. Nothing here
/// depends on how many threads there are, and so no result does.
class RowHalves {
 public:
  explicit RowHalves(const BlockRows& rows);

  std::uint32_t parts() const { return parts_; }
  std::uint32_t begin(std::uint32_t part) const { return part == 0 ? 0 : split_; }
  std::uint32_t end(std::uint32_t part) const { return part + 1 == parts_ ? size_ : split_; }
  /// Where the part's own blocks of row i end; those with the other part follow.
  std::uint32_t rowEnd(std::uint32_t i) const { return row_end_[i]; }
  /// Rows [firstCoupled, lastCoupled) have all blocks between the parts.
  std::uint32_t firstCoupled() const { return first_coupled_; }
  std::uint32_t lastCoupled() const { return split_; }

 private:
  std::uint32_t size_, parts_, split_, first_coupled_;
  std::vector<std::uint32_t> row_end_;
};

}  // namespace mass_spring
