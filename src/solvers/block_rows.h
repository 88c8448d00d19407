#pragma once

#include <cstdint>
#include <vector>

namespace mass_spring {

/// Which blocks of a symmetric matrix exist, for one level of a multigrid: the strict upper
/// triangle by rows, columns ascending.
struct BlockRows {
  std::vector<std::uint32_t> start{0};  ///< of each row, and the end of the last
  std::vector<std::uint32_t> column;

  std::uint32_t size() const { return static_cast<std::uint32_t>(start.size()) - 1; }
};

}  // namespace mass_spring
