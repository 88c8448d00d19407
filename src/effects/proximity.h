#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>

namespace mass_spring {

/// Two elements that may touch, by four particles.
enum class Elements : std::uint8_t {
  kParticleAndTriangle,  ///< 0 and 1 2 3
  kSegments,             ///< 0 1 and 2 3; a segment of length 0 is a particle alone
};

/// The particles' positions [m], a column each.
using Corners = Eigen::Matrix<double, 3, 4>;

/// The nearest points of two elements: X weights = distance normal. As these points are the
/// nearest ones, the distance changes with X by normal weights^T alone.
struct Proximity {
  double distance;          ///< m, >= 0
  Eigen::Vector3d normal;   ///< unit, towards the first element
  Eigen::Vector4d weights;  ///< of the first element's particles sum 1, of the second's -1
  /// The directions in which the weights are free: none between two corners, one where a corner
  /// is nearest to a line, two where a corner is nearest to a plane, or a line to a line.
  int freedoms;
  Eigen::Matrix<double, 4, 2> free_weights;
};
Proximity proximity(Elements elements, const Corners& x);

/// m, no more than their distance, and much cheaper: that of their boxes, or along the line between
/// their middles.
double leastDistance(Elements elements, const Corners& x);
/// The same for all places on the straight ways of the corners, on which they go evenly.
/// @param enough  m, what is above that is not asked for more precisely
double leastDistance(Elements elements, const Corners& from, const Corners& to,
                     double enough = std::numeric_limits<double>::infinity());

/// How weights and normal change where the corners move.
struct ProximityRate {
  Eigen::Vector4d weights;
  Eigen::Vector3d normal;
};
ProximityRate rate(const Proximity& near, const Corners& x, const Corners& dx);

/// m, the most by which the distance can change where the corners move by dx.
double mostApproach(Elements elements, const Corners& dx);

/// Whether the four corners span a volume of the other sign: a particle has come to the other side
/// of a triangle's plane, inside or outside of it.
bool changesSides(const Corners& from, const Corners& to);

/// Where corners move evenly from one place to another: the nearest points just before the elements
/// first touch, or nothing if they do not. (Conservative advancement: the distance cannot fall
/// faster than the elements approach.)
std::optional<Proximity> firstTouch(Elements elements, const Corners& from, const Corners& to);

}  // namespace mass_spring
