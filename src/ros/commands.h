#pragma once

#include <mass_spring_sim/ForceCommand.h>
#include <mass_spring_sim/PinCommand.h>
#include <ros/ros.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include <string>

#include "conversions.h"
#include "physics_loop.h"
#include "publishers.h"

namespace mass_spring {

/// Takes commands from ~force and ~pin to the physics loop and says on ~applied and ~rejected what
/// became of them.
class Commands {
 public:
  /// @param nh        private node handle, whose queue has one thread, so that commands keep their
  ///                  order
  /// @param frame_id  the scene's
  Commands(ros::NodeHandle nh, std::string frame_id, PhysicsLoop& loop, Publishers& publishers);

 private:
  void onForce(const ros::MessageEvent<const mass_spring_sim::ForceCommand>& event);
  void onPin(const ros::MessageEvent<const mass_spring_sim::PinCommand>& event);
  template <class CoreCommand, class Message>
  void receive(const ros::MessageEvent<const Message>& event, const std::string& topic);
  Eigen::Isometry3d frame(const std::string& frame_id) const;

  const std::string frame_id_;
  PhysicsLoop& loop_;
  Publishers& publishers_;
  tf2_ros::Buffer buffer_;
  tf2_ros::TransformListener listener_;
  ros::Subscriber force_, pin_;
};

}  // namespace mass_spring
