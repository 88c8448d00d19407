#pragma once

#include <string>
#include <vector>

#include "mass_spring_sim/scene.h"
#include "scene/references.h"
#include "scene/tree_reader.h"

namespace mass_spring {

/// The objects of a scene, in bytewise order of their names, with their mesh files.
/// @param directory  what relative mesh paths are relative to; "" = none are taken
/// @param counts     filled with every name there is, also of objects with problems
std::vector<Object> readObjects(const Place& place, const std::string& directory,
                                ParticleCounts& counts);

}  // namespace mass_spring
