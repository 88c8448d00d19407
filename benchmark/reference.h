#pragma once

#include <vector>

#include "mass_spring_sim/scene.h"
#include "mass_spring_sim/state.h"

namespace mass_spring {

/// Where the particles of a scene truly are, and until when that can be said.
struct Reference {
  std::vector<Vectors> frames;  ///< positions [m] after each step of the scene, up to the horizon
  double difference = 0.0;      ///< m, largest up to there between rk4 at h and at h / 2
  bool whole = false;           ///< the horizon lies beyond the duration
  std::vector<char> pinned;     ///< per particle

  /// m, root mean square over the particles that no pin of the scene holds.
  double distance(const Vectors& a, const Vectors& b) const;
};

/// By rk4 in sub-steps far below its limit of stability. The horizon of predictability is the last
/// frame before two runs whose starts are 1e-9 m apart differ by `tolerance` [m].
Reference findReference(const Scene& scene, double duration, double tolerance);

}  // namespace mass_spring
