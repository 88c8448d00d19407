#include <ros/callback_queue.h>
#include <ros/ros.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>

#include "clock.h"
#include "commands.h"
#include "mass_spring_sim/scene_reader.h"
#include "mass_spring_sim/simulation.h"
#include "physics_loop.h"
#include "publishers.h"
#include "services.h"
#include "xmlrpc_tree.h"

namespace {

using namespace mass_spring;

/// The scene that the private parameters describe, ready to run; nullptr if it was refused.
std::unique_ptr<Simulation> loadSimulation(const ros::NodeHandle& nh) {
  XmlRpc::XmlRpcValue parameters;
  const bool any = nh.getParam("", parameters);
  try {
    const Tree tree = any ? toTree(parameters) : Tree{Tree::Map{}};
    return std::make_unique<Simulation>(readScene(tree, ""));
  } catch (const SceneError& error) {
    ROS_FATAL_STREAM("The scene in the parameters " << nh.getNamespace() << " is refused:");
    for (const std::string& problem : error.problems()) ROS_FATAL_STREAM(problem);
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM("The scene cannot be built: " << error.what());
  }
  return nullptr;
}

/// Runs until ROS shuts down.
void run(ros::NodeHandle& nh, Simulation& simulation) {
  Clock clock(nh, ros::Time::isSimTime());
  PhysicsLoop* viewed = nullptr;
  Publishers publishers(nh, simulation, clock, [&viewed] { viewed->redraw(); });
  PhysicsLoop loop(simulation, clock, publishers);
  viewed = &loop;

  ros::CallbackQueue command_queue, step_queue;
  ros::NodeHandle command_nh(nh);
  command_nh.setCallbackQueue(&command_queue);
  Commands commands(command_nh, simulation, loop, publishers);
  loop.start();
  Services services(nh, step_queue, loop);

  ros::AsyncSpinner command_spinner(1, &command_queue), step_spinner(1, &step_queue), spinner(1);
  command_spinner.start();
  step_spinner.start();
  spinner.start();
  ROS_INFO_STREAM("Simulating " << simulation.model().particleCount() << " particles and "
                                << simulation.model().springs.size() << " springs at "
                                << simulation.scene().rate << " Hz"
                                << (simulation.scene().start_paused ? ", paused." : "."));
  if (!simulation.model().scheme_reason.empty()) {
    ROS_INFO_STREAM(simulation.model().scheme_reason << '.');
  }
  ros::waitForShutdown();

  // ROS is shut down by now. Nothing is lost with a step that takes long; its thread, which cannot
  // be interrupted, must not outlive what it works on.
  if (!loop.stop(std::chrono::milliseconds(300))) {
    std::fflush(nullptr);
    std::_Exit(EXIT_SUCCESS);
  }
}

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "mass_spring", ros::init_options::NoSigintHandler);
  // roscpp would handle the first of the two, and the second would leave the node registered.
  std::signal(SIGINT, [](int) { ros::requestShutdown(); });
  std::signal(SIGTERM, [](int) { ros::requestShutdown(); });
  ros::NodeHandle nh("~");
  const std::unique_ptr<Simulation> simulation = loadSimulation(nh);
  if (!simulation) return ros::isShuttingDown() ? EXIT_SUCCESS : EXIT_FAILURE;
  run(nh, *simulation);
  return EXIT_SUCCESS;
}
