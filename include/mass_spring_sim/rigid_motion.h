#pragma once

#include <Eigen/Geometry>

#include "mass_spring_sim/command.h"

namespace mass_spring {

/// How a body goes from one pose to another: its origin evenly along a line, while it turns evenly
/// about it, the shorter way round. Before and after that it is at rest.
class RigidMotion {
 public:
  /// At rest for ever.
  explicit RigidMotion(const Pose& pose);
  /// @param from      pose before it moves
  /// @param to        pose after that
  /// @param begin     s of simulated time
  /// @param duration  s, > 0
  RigidMotion(const Pose& from, const Pose& to, double begin, double duration);

  Pose at(double time) const;
  const Pose& target() const { return to_; }
  /// Does it move then, or later?
  bool lasts(double time) const;
  bool operator==(const RigidMotion& other) const;

  // While it moves.
  const Eigen::Vector3d& velocity() const { return velocity_; }  ///< m/s, of the origin
  const Eigen::Vector3d& spin() const { return spin_; }          ///< rad/s, axes of the scene

 private:
  Pose from_, to_;
  double begin_ = 0.0, duration_ = 0.0;  // s
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero(), spin_ = Eigen::Vector3d::Zero();
};

}  // namespace mass_spring
