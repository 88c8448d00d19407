#include "effects/plasticity.h"

#include <algorithm>
#include <cmath>

namespace mass_spring {
namespace {

// A spring whose ends have met keeps this share of its length at the start: it has a direction to
// push in again.
constexpr double kShortest = 1e-3;

}  // namespace

void creep(const PlasticityOptions& options, double h, const std::vector<Spring>& springs,
           std::size_t count, const Vectors& positions, std::vector<double>& rest_lengths) {
  const double longest = 1.0 + options.yield_strain;
  const double shortest = std::max(1.0 - options.yield_strain, 0.0);
  const double stays = std::exp(-options.creep_rate * h);
  for (const Spring& spring : springs) {
    const double rest = rest_lengths.empty() ? spring.rest_length : rest_lengths[spring.number];
    const double square = (positions.col(spring.j) - positions.col(spring.i)).squaredNorm();
    const bool stretched = square > longest * longest * rest * rest;
    const bool compressed = square < shortest * shortest * rest * rest;
    if ((!stretched && !compressed) || spring.rest_length == 0.0) continue;
    const double goal = std::max(std::sqrt(square) / (stretched ? longest : shortest),
                                 kShortest * spring.rest_length);
    const double crept = goal + (rest - goal) * stays;
    if (crept == rest) continue;
    if (rest_lengths.empty()) {
      rest_lengths.assign(count, 0.0);
      for (const Spring& each : springs) rest_lengths[each.number] = each.rest_length;
    }
    rest_lengths[spring.number] = crept;
  }
}

}  // namespace mass_spring
