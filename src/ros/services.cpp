#include "services.h"

#include <chrono>
#include <future>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "load_simulation.h"
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

Services::Services(ros::NodeHandle nh, ros::CallbackQueue& step_queue, std::string frame_id,
                   PhysicsLoop& loop)
    : nh_(nh), frame_id_(std::move(frame_id)), loop_(loop) {
  set_paused_ = nh.advertiseService(topics::kSetPaused, &Services::setPaused, this);
  reset_ = nh.advertiseService(topics::kReset, &Services::reset, this);
  reload_ = nh.advertiseService(topics::kReload, &Services::reload, this);
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

bool Services::reload(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  // Read and built here, beside the steps of the old scene.
  std::vector<std::string> problems;
  std::shared_ptr<Simulation> simulation = loadSimulation(nh_, problems);
  if (simulation && simulation->scene().frame_id != frame_id_) {
    // Commands in terms of the old frame may be on their way.
    problems = {"frame_id: got '" + simulation->scene().frame_id + "', expected '" + frame_id_ +
                "', which stays while the node runs"};
  }
  response.success = problems.empty();
  if (!response.success) {
    ROS_ERROR_STREAM("The scene in the parameters " << nh_.getNamespace()
                                                    << " is refused; the old one runs on:");
    for (const std::string& problem : problems) {
      ROS_ERROR_STREAM(problem);
      response.message += (response.message.empty() ? "" : "\n") + problem;
    }
    return true;
  }
  const std::string scheme_reason = simulation->model().scheme_reason;
  std::future<PhysicsLoop::Replacement> replacement = loop_.replace(std::move(simulation));
  response.success = await(replacement, response.message);
  if (response.success) {
    response.message = replacement.get().continued ? "the run goes on" : "at the start";
    if (!scheme_reason.empty()) response.message += "; " + scheme_reason;
    ROS_INFO_STREAM("Reloaded: " << response.message << '.');
  }
  return true;
}

bool Services::clearForces(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  return answerCount(loop_.clearForces(), "forces", response);
}

bool Services::clearPins(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  return answerCount(loop_.clearPins(), "pins", response);
}

}  // namespace mass_spring
