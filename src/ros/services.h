#pragma once

#include <mass_spring_sim/GetState.h>
#include <mass_spring_sim/SetState.h>
#include <mass_spring_sim/Step.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <string>
#include <vector>

#include "physics_loop.h"

namespace mass_spring {

/// The services; each is answered when the physics loop has done what it asks for.
class Services {
 public:
  /// @param nh          private node handle, whose queue has a thread of its own
  /// @param step_queue  likewise, for ~step: a call of it may last and holds up no other service
  /// @param frame_id    of the scene, which stays
  Services(ros::NodeHandle nh, ros::CallbackQueue& step_queue, std::string frame_id,
           PhysicsLoop& loop);

  /// Resolved.
  std::vector<std::string> names() const;

 private:
  using TriggerCall = ros::ServiceEvent<std_srvs::Trigger::Request, std_srvs::Trigger::Response>;
  using SetStateCall =
      ros::ServiceEvent<mass_spring_sim::SetState::Request, mass_spring_sim::SetState::Response>;

  bool setPaused(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response);
  bool step(mass_spring_sim::Step::Request& request, mass_spring_sim::Step::Response& response);
  bool reset(TriggerCall& call);
  bool reload(TriggerCall& call);
  bool clearForces(TriggerCall& call);
  bool clearPins(TriggerCall& call);
  bool getState(mass_spring_sim::GetState::Request& request,
                mass_spring_sim::GetState::Response& response);
  bool setState(SetStateCall& call);

  const ros::NodeHandle nh_;  ///< whose parameters are the scene
  const std::string frame_id_;
  PhysicsLoop& loop_;
  ros::ServiceServer set_paused_, step_, reset_, reload_, clear_forces_, clear_pins_, get_state_,
      set_state_;
};

}  // namespace mass_spring
