#pragma once

#include <mass_spring_sim/ForceCommand.h>
#include <mass_spring_sim/PinCommand.h>
#include <mass_spring_sim/ShapeCommand.h>
#include <ros/ros.h>

#include <string>

#include "conversions.h"
#include "frames.h"
#include "physics_loop.h"
#include "publishers.h"

namespace mass_spring {

/// Takes commands from ~force, ~pin and ~shape to the physics loop and says on ~applied and
/// ~rejected what became of them.
class Commands {
 public:
  /// @param nh  private node handle, whose queue has one thread, so that commands keep their order
  Commands(ros::NodeHandle nh, const Frames& frames, PhysicsLoop& loop, Publishers& publishers);

 private:
  void onForce(const ros::MessageEvent<const mass_spring_sim::ForceCommand>& event);
  void onPin(const ros::MessageEvent<const mass_spring_sim::PinCommand>& event);
  void onShape(const ros::MessageEvent<const mass_spring_sim::ShapeCommand>& event);
  template <class CoreCommand, class Message>
  void receive(const ros::MessageEvent<const Message>& event, const std::string& topic);

  const Frames& frames_;
  PhysicsLoop& loop_;
  Publishers& publishers_;
  ros::Subscriber force_, pin_, shape_;
};

}  // namespace mass_spring
