#pragma once

#include <vector>

#include "mass_spring_sim/model.h"
#include "mass_spring_sim/scene.h"
#include "mass_spring_sim/state.h"

namespace mass_spring {

/// Which springs break where the particles are: structural and shear ones that are stretched beyond
/// max_strain of their rest length at the start; and with them all shear and bending springs whose
/// ends no longer hang together by a chain of at most three structural ones (they join particles
/// two of these apart, or three, across a cell of a lattice), so that nothing bridges a tear.
/// @return per spring of the model; empty if none breaks, and then no memory was taken
std::vector<char> findBreaking(const TearingOptions& options, const Model& model,
                               const Vectors& positions);

}  // namespace mass_spring
