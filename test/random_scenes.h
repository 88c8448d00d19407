#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "mass_spring_sim/scene.h"

namespace mass_spring {

/// A scene that nobody would write: a random net with stiffness over 8 decades, masses over 6,
/// scrambled, coincident or moving at the start; pins added, teleported and removed, forces pushed,
/// by its timeline; any scheme, any solver, steps of 1 ms to 1 s. The same seed, the same scene.
Scene randomScene(std::uint32_t seed);

/// What went wrong in a run, and before which step.
struct Violation {
  std::uint64_t step;
  std::string what;
};

/// Steps a scene, twice, and checks: never not finite; implicit schemes never fail, explicit ones
/// fail with a reason; what is degraded says so; no energy from nowhere in steps of implicit
/// schemes without command or force; the same bytes again.
std::optional<Violation> findViolation(const Scene& scene, int steps);

/// Writes the scene into a file that `simulate` runs to the same end.
/// @return what to tell the reader: the violation, the seed, the file, the command
std::string reproduction(std::uint32_t seed, const Scene& scene, int steps,
                         const Violation& violation, const std::string& folder);

}  // namespace mass_spring
