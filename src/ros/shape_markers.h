#pragma once

#include <ros/time.h>
#include <visualization_msgs/Marker.h>

#include <Eigen/Geometry>
#include <vector>

#include "mass_spring_sim/scene.h"

namespace mass_spring {

/// The shapes of a scene, if it has any: markers contact/NAME of id 0, and 1 and 2 for the ends of
/// a capsule. Of a plane, a square of 4 m is drawn around its point.
/// @param poses  of the shapes' geometries
std::vector<visualization_msgs::Marker> shapeMarkers(const Scene& scene,
                                                     const std::vector<Eigen::Isometry3d>& poses,
                                                     const ros::Time& stamp);

}  // namespace mass_spring
