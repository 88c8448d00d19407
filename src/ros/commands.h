#pragma once

#include <geometry_msgs/PoseStamped.h>
#include <mass_spring_sim/ForceCommand.h>
#include <mass_spring_sim/PinCommand.h>
#include <mass_spring_sim/ShapeCommand.h>
#include <ros/ros.h>

#include <map>
#include <string>
#include <vector>

#include "conversions.h"
#include "frames.h"
#include "physics_loop.h"
#include "publishers.h"

namespace mass_spring {

/// Takes commands from ~force, ~pin, ~shape and the ~pins/NAME/target of each pin to the physics
/// loop, which says on ~applied and ~rejected what became of them.
class Commands {
 public:
  /// @param nh         private node handle, whose queue has one thread, so that commands keep their
  ///                   order
  /// @param target_nh  likewise, for the targets of pins: to subscribe to one may take long
  Commands(ros::NodeHandle nh, ros::NodeHandle target_nh, const Frames& frames, PhysicsLoop& loop,
           Publishers& publishers);

 private:
  /// Listens to the targets of these pins and no others. On the thread of target_nh.
  void listenTo(const std::vector<std::string>& pins);
  /// @param translate  (message, lookup, command) to a result
  template <class CoreCommand, class Message, class Translate>
  void receive(const ros::MessageEvent<const Message>& event, const std::string& topic,
               Translate translate);
  template <class CoreCommand, class Message>
  ros::Subscriber subscribe(const char* topic);

  ros::NodeHandle nh_, target_nh_;
  const Frames& frames_;
  PhysicsLoop& loop_;
  Publishers& publishers_;
  ros::Subscriber force_, pin_, shape_;
  std::map<std::string, ros::Subscriber> targets_;  ///< by pin; of the thread of target_nh
};

}  // namespace mass_spring
