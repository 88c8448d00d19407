#pragma once

#include <vector>

#include "mass_spring_sim/state.h"
#include "solvers/interpolation.h"

namespace mass_spring {

/// Particles without the order of a grid, as far as thinning them out has to know them.
struct Net {
  struct Pair {
    std::uint32_t i, j;  // i < j
    double length;       // m, at rest, > 0
  };
  std::uint32_t size = 0;
  std::vector<Pair> pairs;  // the coupled ones, in order and none twice
  Vectors positions;        // at rest [m]; without columns where they are not known
};

/// Thins a net out to about twice its spacing: particles become coarse in the order of their
/// numbers (those of uncommonly many neighbors first), unless there is a coarse one nearby, by the
/// way along the pairs. Interpolation from the coarse ones nearby is by inverse distance, corrected
/// to reproduce linear functions of the positions where those are known.
/// @param net  becomes the coarse one
Interpolation coarsen(Net& net);

}  // namespace mass_spring
