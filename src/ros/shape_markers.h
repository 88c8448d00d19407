#pragma once

#include <visualization_msgs/Marker.h>

#include <vector>

#include "mass_spring_sim/scene.h"

namespace mass_spring {

/// The shapes of a scene, if it has any: markers contact/NAME of id 0, and 1 and 2 for the ends of
/// a capsule. Of a plane, a square of 4 m is drawn around its point.
std::vector<visualization_msgs::Marker> shapeMarkers(const Scene& scene);

}  // namespace mass_spring
