#pragma once

#include <vector>

#include "mass_spring_sim/state.h"

namespace mass_spring {

/// What acts on the particles from outside during one sub-step.
struct Drive {
  const std::vector<char>& pinned;  ///< per particle
  const Vectors& pin_positions;     ///< m, at the end of the sub-step; columns of pinned particles
  const Vectors* loads;             ///< N per particle, or nullptr for none
};

/// How one sub-step went.
struct SubstepReport {
  bool converged = true;
  std::uint32_t newton_iterations = 0;
  std::uint32_t linear_iterations = 0;
  std::uint32_t factorizations = 0;
  std::uint32_t projected_springs = 0;
  double residual = 0.0;  ///< relative
};

}  // namespace mass_spring
