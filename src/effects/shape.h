#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <variant>

#include "effects/rigid_motion.h"
#include "mass_spring_sim/scene.h"

namespace mass_spring {

/// How a point lies to a shape. Shapes are convex: the second derivative of the distance, in 1/m,
/// is positive semidefinite.
struct Surface {
  double distance;            ///< m, < 0 inside
  Eigen::Vector3d normal;     ///< unit vector, the gradient of the distance
  Eigen::Matrix3d curvature;  ///< 1/m, the derivative of the normal
};

/// A rigid body, which moves only as it is told to. Its origin is its center (a plane's point, the
/// middle of a capsule); its axes are at the start those of the scene, but for a box, which has its
/// orientation.
class Shape {
 public:
  explicit Shape(const ContactShape& shape);

  const std::string& name() const { return name_; }
  /// Has it the same name, geometry and start?
  bool startsLike(const Shape& other) const;
  const Pose& start() const { return start_; }
  const Pose& pose() const { return pose_; }
  const RigidMotion& motion() const { return motion_; }

  /// From now on it moves so; before setTime() it is where it was.
  void move(const RigidMotion& motion) { motion_ = motion; }
  void reset();  ///< at its start, at rest
  /// It is where its motion has it then [s]. @return whether it moves then, or later
  bool setTime(double time);
  bool moves() const { return moves_; }  ///< at the time set
  /// m/s, of the place of the body that is there at the time set.
  Eigen::Vector3d velocityAt(const Eigen::Vector3d& point) const;
  Eigen::Vector3d spin() const;  ///< rad/s, at the time set

  /// Of the geometry: the body's, with z along a capsule and out of a plane.
  Eigen::Isometry3d geometryPose() const { return geometry_pose_; }
  /// m, from the origin to the farthest place on the surface; nothing for a plane, which has none.
  std::optional<double> radius() const;
  /// m, from a point of the scene to the surface, < 0 inside.
  double distance(const Eigen::Vector3d& point) const;
  /// Where the nearest place on the surface is not unique (the middle of a sphere, the ridges
  /// inside a box), one of them is taken, the same every time.
  Surface at(const Eigen::Vector3d& point) const;

 private:
  void place(const Pose& pose);

  struct Plane {  // z = 0; z > 0 is free
    bool operator==(const Plane&) const { return true; }
  };
  struct Sphere {
    double radius;
    bool operator==(const Sphere& other) const { return radius == other.radius; }
  };
  struct Box {
    Eigen::Vector3d half;
    bool operator==(const Box& other) const { return half == other.half; }
  };
  struct Capsule {  // along z
    double half, radius;
    bool operator==(const Capsule& other) const {
      return half == other.half && radius == other.radius;
    }
  };

  std::string name_;
  std::variant<Plane, Sphere, Box, Capsule> geometry_;
  Eigen::Matrix3d turn_ = Eigen::Matrix3d::Identity();  // of the geometry in the body
  Pose start_, pose_;
  Eigen::Isometry3d geometry_pose_;
  RigidMotion motion_;
  bool moves_ = false;
};

}  // namespace mass_spring
