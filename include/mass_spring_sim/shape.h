#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <variant>

#include "mass_spring_sim/rigid_motion.h"
#include "mass_spring_sim/scene.h"

namespace mass_spring {

/// How a point lies to a shape. Shapes are convex: the second derivative of the distance, in 1/m,
/// is positive semidefinite.
struct Surface {
  double distance;            ///< m, < 0 inside
  Eigen::Vector3d normal;     ///< unit vector, the gradient of the distance
  Eigen::Matrix3d curvature;  ///< 1/m, the derivative of the normal
};

/// A rigid body. Its origin is its center (a plane's point, the middle of a capsule); its axes are
/// at the start those of the scene, but for a box, which has its orientation. Where it is at a time
/// is for its motion to say, which belongs to the state: see PlacedShape.
class Shape {
 public:
  explicit Shape(const ContactShape& shape);

  const std::string& name() const { return name_; }
  const Pose& start() const { return start_; }
  /// Are name, geometry and start the same?
  bool operator==(const Shape& other) const;
  /// m, from the origin to the farthest place on the surface; nothing for a plane, which has none.
  std::optional<double> radius() const;

 private:
  friend class PlacedShape;

  struct HalfSpace {  // z < 0
    bool operator==(const HalfSpace&) const { return true; }
  };
  struct Ball {
    double radius;
    bool operator==(const Ball& other) const { return radius == other.radius; }
  };
  struct Cuboid {
    Eigen::Vector3d half;
    bool operator==(const Cuboid& other) const { return half == other.half; }
  };
  struct Rod {  // along z
    double half, radius;
    bool operator==(const Rod& other) const { return half == other.half && radius == other.radius; }
  };
  // Each function of a geometry is an overload for every alternative: without one of them, nothing
  // compiles.
  static double distance(const HalfSpace&, const Eigen::Vector3d& p);
  static double distance(const Ball& ball, const Eigen::Vector3d& p);
  static double distance(const Cuboid& cuboid, const Eigen::Vector3d& p);
  static double distance(const Rod& rod, const Eigen::Vector3d& p);
  static Surface surface(const HalfSpace&, const Eigen::Vector3d& p);
  static Surface surface(const Ball& ball, const Eigen::Vector3d& p);
  static Surface surface(const Cuboid& cuboid, const Eigen::Vector3d& p);
  static Surface surface(const Rod& rod, const Eigen::Vector3d& p);
  static std::optional<double> radius(const HalfSpace&) { return std::nullopt; }
  static std::optional<double> radius(const Ball& ball) { return ball.radius; }
  static std::optional<double> radius(const Cuboid& cuboid) { return cuboid.half.norm(); }
  static std::optional<double> radius(const Rod& rod) { return rod.half + rod.radius; }
  void take(const Plane& plane);
  void take(const Sphere& sphere);
  void take(const Box& box);
  void take(const Capsule& capsule);

  std::string name_;
  std::variant<HalfSpace, Ball, Cuboid, Rod> geometry_;
  Eigen::Matrix3d turn_ = Eigen::Matrix3d::Identity();  // of the geometry in the body
  Pose start_;
};

/// A shape where its motion has it at a time.
class PlacedShape {
 public:
  /// @param shape   that outlives this
  /// @param motion  likewise
  /// @param time    s of simulated time
  PlacedShape(const Shape& shape, const RigidMotion& motion, double time);

  const Pose& pose() const { return pose_; }
  /// The pose of the geometry: the axes of the body, but with z along a capsule and out of a plane.
  Eigen::Isometry3d geometryPose() const { return geometry_pose_; }
  /// Does it move, or will it?
  bool moves() const { return moves_; }
  /// m/s, of the place of the body that is there.
  Eigen::Vector3d velocityAt(const Eigen::Vector3d& point) const;
  Eigen::Vector3d spin() const;  ///< rad/s
  /// m, from a point of the scene to the surface, < 0 inside.
  double distance(const Eigen::Vector3d& point) const;
  /// The nearest place on the surface. If several are nearest (in the middle of a sphere, on the
  /// ridges inside a box), the function returns the same one every time.
  Surface at(const Eigen::Vector3d& point) const;

 private:
  Eigen::Vector3d inGeometry(const Eigen::Vector3d& point) const {
    return geometry_pose_.linear().transpose() * (point - geometry_pose_.translation());
  }

  const Shape* shape_;
  const RigidMotion* motion_;
  Pose pose_;
  Eigen::Isometry3d geometry_pose_;
  bool moves_;
};

}  // namespace mass_spring
