#pragma once

#include <geometry_msgs/Point.h>
#include <std_msgs/ColorRGBA.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "mass_spring_sim/model.h"
#include "mass_spring_sim/state.h"

namespace mass_spring {

/// Corners of the cross-section of a tube.
constexpr std::size_t kTubeSides = 6;

/// The color of a marker.
/// @param rgb    [0, 1] each
/// @param alpha  [0, 1]
std_msgs::ColorRGBA toColor(const Eigen::Vector3d& rgb, double alpha);

/// @param position  m
geometry_msgs::Point toPoint(const Eigen::Vector3d& position);

/// The color of a surface under the light of the scene, which RViz does not apply to a list of
/// triangles with colors: it comes from above and from the side of -y, with a weaker light from the
/// other side.
/// @param rgb     in full light, [0, 1] each
/// @param normal  of unit length, on the side that is seen, in the frame of the scene; or 0
/// @return [0, 1] each
Eigen::Vector3d lit(const Eigen::Vector3d& rgb, const Eigen::Vector3d& normal);

/// The color of the back of a surface: the one of its front, paler.
Eigen::Vector3d backColor(const Eigen::Vector3d& front);

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

/// The surface of an object: the triangles of the model or, of a lattice, its outer faces between
/// structural springs.
/// @return global particle numbers
Triangles surfaceOf(const Model& model, const ModelObject& object);

/// Unit normals of the particles of an object, or 0 where there is none; weighted by the areas of
/// the triangles around the particle.
/// @return one column for each particle of the object
Vectors vertexNormals(const Triangles& triangles, const ModelObject& object,
                      const Vectors& positions);

/// Whether each edge lies between two triangles that turn the same way, so that the back of the
/// surface cannot be seen.
bool isClosed(const Triangles& triangles);

/// Triangles of tubes around the structural springs of a rope, which join successive particles.
/// @param radius   m, > 0
/// @param colors   [0, 1], in full light: one column for each particle of the object
/// @param out_points, out_colors  6 kTubeSides more for each spring whose ends do not coincide
void appendTubes(const Model& model, const ModelObject& object, double radius,
                 const Vectors& positions, const Vectors& colors,
                 std::vector<geometry_msgs::Point>& out_points,
                 std::vector<std_msgs::ColorRGBA>& out_colors);

}  // namespace mass_spring
