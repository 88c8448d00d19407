#pragma once

#include <string>
#include <vector>

#include "mass_spring_sim/scene.h"

namespace mass_spring {

/// A scene with the time over which it is looked at.
struct VariedScene {
  std::string name;
  Scene scene;
  double duration;  ///< s
};

/// Scenes of many kinds, soft and stiff: those that the package comes with and can be compared with
/// a reference in seconds, and one of each kind of object, load and pin, each once more with all
/// stiffnesses a thousand times as large. No scheme or accuracy is set; one thread.
std::vector<VariedScene> variedScenes();

}  // namespace mass_spring
