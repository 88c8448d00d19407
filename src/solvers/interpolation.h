#pragma once

#include <cstdint>
#include <vector>

namespace mass_spring {

/// Displacements of fine particles as weighted means of those of coarse ones; the weights of a
/// particle sum to 1. A particle that is coupled with no other has none: smoothing solves for it.
struct Interpolation {
  struct Entry {
    std::uint32_t particle;
    float weight;
  };
  std::uint32_t coarse_size = 0;
  std::vector<std::uint32_t> start{
      0};                      ///< of each fine particle's entries, and the end of the last
  std::vector<Entry> entries;  ///< coarse particles

  std::uint32_t fineSize() const { return static_cast<std::uint32_t>(start.size()) - 1; }
};

/// The same by coarse particles: the fine ones that each of them moves.
Interpolation transposed(const Interpolation& interpolation);

}  // namespace mass_spring
