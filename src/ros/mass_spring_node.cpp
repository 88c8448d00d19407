#include <ros/callback_queue.h>
#include <ros/ros.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "clock.h"
#include "commands.h"
#include "load_simulation.h"
#include "mass_spring_sim/simulation.h"
#include "physics_loop.h"
#include "publishers.h"
#include "registration.h"
#include "services.h"

namespace {

using namespace mass_spring;

constexpr std::chrono::milliseconds kPatience(300);

/// What is to be told of a simulation before it runs.
void announce(const Simulation& simulation) {
  ROS_INFO_STREAM("Simulating " << simulation.model().particleCount() << " particles and "
                                << simulation.model().springs.size() << " springs at "
                                << simulation.scene().rate << " Hz"
                                << (simulation.scene().start_paused ? ", paused." : "."));
  if (!simulation.model().scheme_reason.empty()) {
    ROS_INFO_STREAM(simulation.model().scheme_reason << '.');
  }
}

/// Runs until ROS shuts down.
void run(ros::NodeHandle& nh, std::shared_ptr<Simulation> simulation, Clock::Source source) {
  announce(*simulation);
  const std::string frame_id = simulation->scene().frame_id;
  Clock clock(nh, source);
  const Frames frames(frame_id);
  FrameFollower follower(frames);
  PhysicsLoop* viewed = nullptr;
  Publishers publishers(nh, simulation, clock, follower,
                        [&viewed](Publishers::Topic topic) { viewed->show(topic); });
  PhysicsLoop loop(std::move(simulation), clock, follower, publishers);
  viewed = &loop;

  ros::CallbackQueue command_queue, target_queue, step_queue;
  ros::NodeHandle command_nh(nh), target_nh(nh);
  command_nh.setCallbackQueue(&command_queue);
  target_nh.setCallbackQueue(&target_queue);
  Commands commands(command_nh, target_nh, frames, loop, publishers);
  loop.start();
  Services services(nh, step_queue, frame_id, loop);
  Registration registration(services.names());

  ros::AsyncSpinner command_spinner(1, &command_queue), target_spinner(1, &target_queue),
      step_spinner(1, &step_queue), spinner(1);
  command_spinner.start();
  target_spinner.start();
  step_spinner.start();
  spinner.start();
  ros::waitForShutdown();

  // ROS is shut down by now. Nothing is lost with a step that takes long, or with a master that
  // does not answer; a thread that cannot be interrupted must not outlive what it works on.
  if (!loop.stop(kPatience) || !registration.stop(kPatience)) {
    std::fflush(nullptr);
    std::_Exit(EXIT_SUCCESS);
  }
}

}  // namespace

int main(int argc, char** argv) {
  // Each line is told when it is said, also to roslaunch and other pipes.
  std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);
  ros::init(argc, argv, "mass_spring", ros::init_options::NoSigintHandler);
  // roscpp would handle the first of the two, and the second would leave the node registered.
  std::signal(SIGINT, [](int) { ros::requestShutdown(); });
  std::signal(SIGTERM, [](int) { ros::requestShutdown(); });
  ros::NodeHandle nh("~");
  std::vector<std::string> problems;
  const bool follow = loadExternalClock(nh, problems);
  std::shared_ptr<Simulation> simulation =
      problems.empty() ? loadSimulation(nh, problems) : nullptr;
  if (!simulation) {
    ROS_FATAL_STREAM("The scene in the parameters " << nh.getNamespace() << " is refused:");
    for (const std::string& problem : problems) ROS_FATAL_STREAM(problem);
    return ros::isShuttingDown() ? EXIT_SUCCESS : EXIT_FAILURE;
  }
  run(nh, std::move(simulation),
      follow                   ? Clock::Source::kFollowed
      : ros::Time::isSimTime() ? Clock::Source::kMaster
                               : Clock::Source::kWall);
  return EXIT_SUCCESS;
}
