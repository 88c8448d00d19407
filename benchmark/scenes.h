#pragma once

#include "mass_spring_sim/scene.h"

namespace mass_spring {

/// The scenes of this folder's YAML files.

/// hanging_cloth.yaml with n x n particles.
Scene hangingCloth(int n);
/// hanging_lattice.yaml with n x n x n particles.
Scene hangingLattice(int n);
/// swinging_rope.yaml with that many links.
Scene swingingRope(int links);

}  // namespace mass_spring
