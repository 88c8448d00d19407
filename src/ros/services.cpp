#include "services.h"

#include <chrono>
#include <future>
#include <string>

#include "topics.h"

namespace mass_spring {

namespace {

/// Waits for the physics loop. Shutting ROS down waits for calls at work, so they end with it.
/// @return false if there will be no result; the message says so
template <class Result>
bool await(std::future<Result>& future, std::string& message) {
  while (!ros::isShuttingDown()) {
    if (future.wait_for(std::chrono::milliseconds(20)) == std::future_status::ready) return true;
  }
  message = "the node is shutting down";
  return false;
}

/// The answer to ~clear_forces and ~clear_pins.
bool answerCount(std::future<std::uint32_t> count, const std::string& what,
                 std_srvs::Trigger::Response& response) {
  response.success = await(count, response.message);
  if (response.success) response.message = std::to_string(count.get()) + " " + what + " cleared";
  return true;
}

}  // namespace

Services::Services(ros::NodeHandle nh, ros::CallbackQueue& step_queue, PhysicsLoop& loop)
    : loop_(loop) {
  set_paused_ = nh.advertiseService(topics::kSetPaused, &Services::setPaused, this);
  reset_ = nh.advertiseService(topics::kReset, &Services::reset, this);
  clear_forces_ = nh.advertiseService(topics::kClearForces, &Services::clearForces, this);
  clear_pins_ = nh.advertiseService(topics::kClearPins, &Services::clearPins, this);
  nh.setCallbackQueue(&step_queue);
  step_ = nh.advertiseService(topics::kStep, &Services::step, this);
}

bool Services::setPaused(std_srvs::SetBool::Request& request,
                         std_srvs::SetBool::Response& response) {
  std::future<bool> change = loop_.setPaused(request.data);
  response.success = await(change, response.message);
  if (response.success) {
    response.message =
        std::string(change.get() ? "now " : "already ") + (request.data ? "paused" : "running");
  }
  return true;
}

bool Services::step(mass_spring_sim::Step::Request& request,
                    mass_spring_sim::Step::Response& response) {
  std::future<PhysicsLoop::StepOutcome> future = loop_.step(request.steps);
  response.success = await(future, response.message);
  if (response.success) {
    const PhysicsLoop::StepOutcome outcome = future.get();
    response.success = outcome.success;
    response.message = outcome.message;
    response.step = outcome.step;
    response.sim_time = outcome.time;
  }
  return true;
}

bool Services::reset(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  std::future<void> done = loop_.reset();
  response.success = await(done, response.message);
  if (response.success) response.message = "at the start";
  return true;
}

bool Services::clearForces(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  return answerCount(loop_.clearForces(), "forces", response);
}

bool Services::clearPins(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  return answerCount(loop_.clearPins(), "pins", response);
}

}  // namespace mass_spring
