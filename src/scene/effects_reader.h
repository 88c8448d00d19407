#pragma once

#include "mass_spring_sim/scene.h"
#include "scene/tree_reader.h"

namespace mass_spring {

/// The effects that a scene calls for; shapes of contact in bytewise order of their names.
void readEffects(const Place& place, EffectOptions& effects);

}  // namespace mass_spring
