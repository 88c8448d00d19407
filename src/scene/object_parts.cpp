#include "object_parts.h"

#include <Eigen/Geometry>
#include <utility>

namespace mass_spring {

ObjectParts partsAtRest(Vectors positions, double mass) {
  const Eigen::Index count = positions.cols();
  ObjectParts parts;
  parts.positions = std::move(positions);
  parts.velocities = Vectors::Zero(3, count);
  parts.masses = Eigen::VectorXd::Constant(count, mass / static_cast<double>(count));
  return parts;
}

Eigen::Matrix3d rotation(const Eigen::Vector3d& roll_pitch_yaw) {
  return (Eigen::AngleAxisd(roll_pitch_yaw.z(), Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(roll_pitch_yaw.y(), Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(roll_pitch_yaw.x(), Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

}  // namespace mass_spring
