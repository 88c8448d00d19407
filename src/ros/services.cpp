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

/// Refuses what cannot be a vector per particle.
CommandResult toVectors(const std::vector<double>& numbers, const char* field, Vectors& vectors) {
  if (numbers.size() % 3 != 0) {
    return {Refusal::kBadLength, std::string(field) + ": got " + std::to_string(numbers.size()) +
                                     " numbers, expected 3 per particle"};
  }
  vectors =
      Eigen::Map<const Vectors>(numbers.data(), 3, static_cast<Eigen::Index>(numbers.size() / 3));
  return {};
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
  get_state_ = nh.advertiseService(topics::kGetState, &Services::getState, this);
  set_state_ = nh.advertiseService(topics::kSetState, &Services::setState, this);
  nh.setCallbackQueue(&step_queue);
  step_ = nh.advertiseService(topics::kStep, &Services::step, this);
}

std::vector<std::string> Services::names() const {
  std::vector<std::string> names;
  for (const ros::ServiceServer* server : {&set_paused_, &step_, &reset_, &reload_, &clear_forces_,
                                           &clear_pins_, &get_state_, &set_state_}) {
    names.push_back(server->getService());
  }
  // These roscpp offers by itself.
  for (const char* name : {"get_loggers", "set_logger_level"}) {
    names.push_back(nh_.resolveName(name));
  }
  return names;
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

bool Services::reset(TriggerCall& call) {
  std_srvs::Trigger::Response& response = call.getResponse();
  std::future<void> done = loop_.reset(call.getCallerName());
  response.success = await(done, response.message);
  if (response.success) response.message = "at the start";
  return true;
}

bool Services::reload(TriggerCall& call) {
  std_srvs::Trigger::Response& response = call.getResponse();
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
  std::future<PhysicsLoop::Replacement> replacement =
      loop_.replace(std::move(simulation), call.getCallerName());
  response.success = await(replacement, response.message);
  if (response.success) {
    response.message = replacement.get().continued ? "the run goes on" : "at the start";
    if (!scheme_reason.empty()) response.message += "; " + scheme_reason;
    ROS_INFO_STREAM("Reloaded: " << response.message << '.');
  }
  return true;
}

bool Services::clearForces(TriggerCall& call) {
  return answerCount(loop_.clearForces(call.getCallerName()), "forces", call.getResponse());
}

bool Services::clearPins(TriggerCall& call) {
  return answerCount(loop_.clearPins(call.getCallerName()), "pins", call.getResponse());
}

bool Services::getState(mass_spring_sim::GetState::Request&,
                        mass_spring_sim::GetState::Response& response) {
  std::future<mass_spring_sim::ParticleStates> state = loop_.state();
  response.success = await(state, response.message);
  if (response.success) response.state = state.get();
  return true;
}

bool Services::setState(SetStateCall& call) {
  const mass_spring_sim::SetState::Request& request = call.getRequest();
  mass_spring_sim::SetState::Response& response = call.getResponse();
  Vectors positions, velocities;
  CommandResult result = toVectors(request.positions, "positions", positions);
  if (result.accepted()) result = toVectors(request.velocities, "velocities", velocities);
  if (result.accepted()) {
    if (request.velocities.empty()) velocities.setZero(3, positions.cols());
    std::future<CommandResult> done =
        loop_.setState(std::move(positions), std::move(velocities), call.getCallerName());
    response.success = await(done, response.message);
    if (!response.success) return true;
    result = done.get();
  }
  response.success = result.accepted();
  response.message = result.message;
  return true;
}

}  // namespace mass_spring
