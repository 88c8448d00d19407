#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include <Eigen/Geometry>
#include <string>

namespace mass_spring {

/// What tf knows of other frames, in terms of the scene's. For any thread.
class Frames {
 public:
  explicit Frames(std::string frame_id);

  struct Placed {
    Eigen::Isometry3d pose;
    ros::Time stamp;  ///< of the newest that is known; 0 = for ever
  };
  /// @param frame_id  "" is the scene's frame itself
  /// @throws tf2::TransformException if it is not known; the text names which frame is missing
  Placed find(const std::string& frame_id) const;

 private:
  geometry_msgs::TransformStamped lookUp(const std::string& frame_id) const;

  const std::string frame_id_;
  tf2_ros::Buffer buffer_;
  tf2_ros::TransformListener listener_;
};

}  // namespace mass_spring
