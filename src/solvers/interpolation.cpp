#include "solvers/interpolation.h"

namespace mass_spring {

Interpolation transposed(const Interpolation& interpolation) {
  Interpolation result;
  result.coarse_size = interpolation.fineSize();
  result.start.assign(interpolation.coarse_size + 1, 0);
  for (const auto& entry : interpolation.entries) ++result.start[entry.particle + 1];
  for (std::uint32_t c = 0; c < interpolation.coarse_size; ++c) {
    result.start[c + 1] += result.start[c];
  }
  result.entries.resize(interpolation.entries.size());
  std::vector<std::uint32_t> next(result.start.begin(), result.start.end() - 1);
  for (std::uint32_t i = 0; i < interpolation.fineSize(); ++i) {
    for (std::uint32_t e = interpolation.start[i]; e < interpolation.start[i + 1]; ++e) {
      const Interpolation::Entry& entry = interpolation.entries[e];
      result.entries[next[entry.particle]++] = {i, entry.weight};
    }
  }
  return result;
}

}  // namespace mass_spring
