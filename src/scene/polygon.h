#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace mass_spring {

/// Cuts a polygon into triangles of its corners, with the same sense of rotation. A convex polygon
/// of four corners is cut along its shorter diagonal, any other by taking off one ear after the
/// other. Corners that do not lie in a plane are seen along the polygon's mean normal.
/// @param vertices  positions
/// @param corners   at least 3 indices into the vertices, in order around the polygon
/// @return two triangles less than corners; fewer if the polygon crosses itself or has no area
std::vector<std::array<std::uint32_t, 3>> cutPolygon(const std::vector<Eigen::Vector3d>& vertices,
                                                     std::vector<std::uint32_t> corners);

}  // namespace mass_spring
