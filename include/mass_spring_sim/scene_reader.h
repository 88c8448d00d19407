#pragma once

#include <string>

#include "mass_spring_sim/scene.h"
#include "mass_spring_sim/tree.h"

namespace mass_spring {

/// Reads and validates a scene: unknown keys are errors (with the nearest known key), every problem
/// is collected, NaN and infinity are refused everywhere. Loads the mesh files that the scene
/// names.
/// @param tree       as it was read
/// @param directory  folder of relative mesh paths; "" = only package:// and absolute paths
/// @throws SceneError with all problems
Scene readScene(const Tree& tree, const std::string& directory);

/// readYamlFile + readScene, with mesh paths relative to the file.
Scene readSceneFile(const std::string& path);

/// The resolved scene as YAML: every default spelled out, numbers with all digits. Reading it again
/// gives the same scene.
std::string toYaml(const Scene& scene);

}  // namespace mass_spring
