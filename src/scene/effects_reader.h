#pragma once

#include <vector>

#include "mass_spring_sim/scene.h"
#include "scene/tree_reader.h"

namespace mass_spring {

/// The effects that a scene calls for; shapes of contact in bytewise order of their names.
/// @param objects  of the scene, for effects that need something to act on; nullptr = not known
void readEffects(const Place& place, const std::vector<Object>* objects, EffectOptions& effects);

}  // namespace mass_spring
