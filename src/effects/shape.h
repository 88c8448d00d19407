#pragma once

#include <Eigen/Geometry>
#include <string>
#include <variant>

#include "mass_spring_sim/scene.h"

namespace mass_spring {

/// How a point lies to a shape. Shapes are convex: the second derivative of the distance, in 1/m,
/// is positive semidefinite.
struct Surface {
  double distance;            ///< m, < 0 inside
  Eigen::Vector3d normal;     ///< unit vector, the gradient of the distance
  Eigen::Matrix3d curvature;  ///< 1/m, the derivative of the normal
};

/// A rigid body: a geometry in a frame of its own, which a pose places in the scene.
class Shape {
 public:
  explicit Shape(const ContactShape& shape);

  const std::string& name() const { return name_; }
  const Eigen::Isometry3d& pose() const { return pose_; }
  /// m, from a point of the scene to the surface, < 0 inside.
  double distance(const Eigen::Vector3d& point) const;
  /// Where the nearest place on the surface is not unique (the middle of a sphere, the ridges
  /// inside a box), one of them is taken, the same every time.
  Surface at(const Eigen::Vector3d& point) const;

 private:
  struct Plane {};  // z = 0; z > 0 is free
  struct Sphere {
    double radius;
  };
  struct Box {
    Eigen::Vector3d half;
  };
  struct Capsule {  // along z
    double half, radius;
  };

  std::string name_;
  std::variant<Plane, Sphere, Box, Capsule> geometry_;
  Eigen::Isometry3d pose_;
};

}  // namespace mass_spring
