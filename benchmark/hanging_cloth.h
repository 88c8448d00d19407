#pragma once

#include "mass_spring_sim/scene.h"

namespace mass_spring {

/// hanging_cloth.yaml with n x n particles.
Scene hangingCloth(int n);

}  // namespace mass_spring
