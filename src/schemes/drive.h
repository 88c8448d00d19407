#pragma once

#include <cstdint>
#include <vector>

#include "effects/effect.h"
#include "mass_spring_sim/state.h"

namespace mass_spring {

/// What acts on the particles from outside during one sub-step. A pinned particle moves evenly with
/// the velocity that it has in the state; nothing accelerates it.
struct Drive {
  const std::vector<char>& pinned;  ///< per particle
  const Vectors* loads;             ///< N per particle, or nullptr for none
  const EffectState& effects;       ///< what effects remember
  double time;                      ///< s, at the start

  /// Where effects are evaluated so long after the start [s].
  Point point(const Vectors& positions, const Vectors& velocities, double after) const {
    return {positions, velocities, time + after, effects};
  }
  bool isPinned(Eigen::Index i) const { return pinned[static_cast<std::size_t>(i)] != 0; }
};

/// How one sub-step went.
struct SubstepReport {
  bool converged = true;
  std::uint32_t newton_iterations = 0;
  std::uint32_t linear_iterations = 0;
  std::uint32_t factorizations = 0;
  std::uint32_t projected_springs = 0;
  double residual = 0.0;        ///< relative
  double estimated_error = -1;  ///< m, root mean square over the free particles; -1 = none
};

}  // namespace mass_spring
