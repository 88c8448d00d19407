// Pushes a traveling wave of forces onto one object of a running scene:
//
//   roslaunch mass_spring_sim simulate.launch scene:=cloth
//   rosrun mass_spring_sim push_wave --seconds 5 _acceleration:=8.0 _wavelength:=0.5
//
// Each command lasts for a few periods of sending only: when the program ends, so does the wave.
// kUsage has the options and the parameters.

#include <mass_spring_sim/ForceCommand.h>
#include <mass_spring_sim/ParticleStates.h>
#include <mass_spring_sim/RejectedCommand.h>
#include <mass_spring_sim/Topology.h>
#include <ros/ros.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

constexpr double kSeconds = 10.0;
constexpr char kUsage[] = R"(usage: push_wave [--seconds S] [--help] [_PARAMETER:=VALUE]...

Pushes a traveling wave of forces onto one object of a running scene. Particle i feels the force
m_i a sin(2 pi (f t - s_i / wavelength)) along `push`; s_i is its place along `travel` at the start.

  --seconds S   s of wall time until the wave ends (default: 10)
  --help        this text

Parameters (private)                                    default
  node          name of the simulation's node           mass_spring
  object        name in the scene; "" = the only one    ""
  acceleration  a, m/s^2                                8.0
  frequency     f, Hz                                   1.0
  wavelength    m                                       0.5
  travel, push  directions in the scene's frame         [1, 0, 0], [0, 1, 0]
  rate          commands per second                     50.0
)";

constexpr double kPeriodsPerCommand = 5.0;  // bridges commands that come late

struct Wave {
  double acceleration, frequency, wavelength;  // m/s^2, Hz, m
  Eigen::Vector3d travel, push;                // unit vectors
};

/// As NodeHandle::param, but a parameter of another type is refused rather than passed over.
template <class T>
T parameter(const ros::NodeHandle& nh, const std::string& name, T value) {
  if (nh.hasParam(name) && !nh.getParam(name, value)) {
    throw std::runtime_error(nh.resolveName(name) + ": of the wrong type");
  }
  return value;
}

double positive(const ros::NodeHandle& nh, const std::string& name, double fallback) {
  const double value = parameter(nh, name, fallback);
  if (!(value > 0.0) || !std::isfinite(value)) {
    throw std::runtime_error(nh.resolveName(name) + ": expected a positive number");
  }
  return value;
}

Eigen::Vector3d direction(const ros::NodeHandle& nh, const std::string& name,
                          const std::vector<double>& fallback) {
  const auto values = parameter(nh, name, fallback);
  if (values.size() == 3) {
    const Eigen::Vector3d vector(values[0], values[1], values[2]);
    const double length = vector.norm();
    if (length > 0.0 && std::isfinite(length)) return vector / length;
  }
  throw std::runtime_error(nh.resolveName(name) + ": expected three numbers, not all zero");
}

/// Index of an object in the topology.
std::size_t findObject(const mass_spring_sim::Topology& topology, const std::string& name) {
  if (name.empty() && topology.objects.size() == 1) return 0;
  const auto found = std::find(topology.objects.begin(), topology.objects.end(), name);
  if (found != topology.objects.end()) return found - topology.objects.begin();
  std::string known;
  for (const std::string& object : topology.objects) known += " " + object;
  throw std::runtime_error("no object \"" + name + "\"; there are:" + known);
}

void warn(const mass_spring_sim::RejectedCommand& rejected) {
  if (rejected.sender != ros::this_node::getName()) return;
  ROS_WARN_THROTTLE(1.0, "refused: %s", rejected.message.c_str());
}

/// s that the wave is to last, out of the arguments; nothing if they ask for help.
std::optional<double> readSeconds(int argc, char** argv) {
  ros::V_string arguments;
  ros::removeROSArgs(argc, argv, arguments);
  double seconds = kSeconds;
  for (std::size_t i = 1; i < arguments.size(); ++i) {
    if (arguments[i] == "--help" || arguments[i] == "-h") return std::nullopt;
    if (arguments[i] != "--seconds") {
      throw std::runtime_error("got " + arguments[i] + ", expected --seconds or --help");
    }
    const std::string text = ++i < arguments.size() ? arguments[i] : "nothing";
    char* end = nullptr;
    seconds = std::strtod(text.c_str(), &end);
    if (*end != '\0' || !(seconds > 0.0) || !std::isfinite(seconds)) {
      throw std::runtime_error("--seconds: got " + text + ", expected a positive number");
    }
  }
  return seconds;
}

/// @param seconds  s of wall time from the first push to the end
void run(ros::NodeHandle& nh, double seconds) {
  const Wave wave{positive(nh, "acceleration", 8.0), positive(nh, "frequency", 1.0),
                  positive(nh, "wavelength", 0.5), direction(nh, "travel", {1.0, 0.0, 0.0}),
                  direction(nh, "push", {0.0, 1.0, 0.0})};
  const double rate = positive(nh, "rate", 50.0);
  const std::string node = ros::names::resolve(parameter<std::string>(nh, "node", "mass_spring"));

  ROS_INFO("waiting for a simulation that runs at %s", node.c_str());
  const auto topology =
      ros::topic::waitForMessage<mass_spring_sim::Topology>(node + "/topology", nh);
  const auto state =
      ros::topic::waitForMessage<mass_spring_sim::ParticleStates>(node + "/state", nh);
  if (!topology || !state) return;  // asked to end while waiting

  const std::size_t object = findObject(*topology, parameter<std::string>(nh, "object", ""));
  const std::size_t first = topology->first_particle[object];
  std::vector<double> masses, distances;  // kg; m along the direction of travel
  for (std::size_t p = first; p < first + topology->particle_count[object]; ++p) {
    masses.push_back(topology->masses[p]);
    distances.push_back(
        Eigen::Map<const Eigen::Vector3d>(&state->positions[3 * p]).dot(wave.travel));
  }

  mass_spring_sim::ForceCommand command;
  command.id = ros::this_node::getName();
  command.object = topology->objects[object];
  command.forces.resize(masses.size());
  command.duration = kPeriodsPerCommand / rate;

  auto publisher = nh.advertise<mass_spring_sim::ForceCommand>(node + "/force", 1);
  const ros::Subscriber rejections = nh.subscribe(node + "/rejected", 10, warn);
  // Follows /clock where there is one: it stands still while the simulation is paused.
  const ros::Timer timer = nh.createTimer(ros::Duration(1.0 / rate), [&](const ros::TimerEvent&) {
    const double turns = wave.frequency * ros::Time::now().toSec();
    for (std::size_t i = 0; i < masses.size(); ++i) {
      const double phase = 2.0 * M_PI * (turns - distances[i] / wave.wavelength);
      const Eigen::Vector3d force = masses[i] * wave.acceleration * std::sin(phase) * wave.push;
      command.forces[i].x = force.x();
      command.forces[i].y = force.y();
      command.forces[i].z = force.z();
    }
    publisher.publish(command);
  });
  const ros::WallTimer end = nh.createWallTimer(
      ros::WallDuration(seconds), [](const ros::WallTimerEvent&) { ros::requestShutdown(); }, true);
  ROS_INFO("pushing %s along [%g %g %g] with up to %g m/s^2 for %g s; Ctrl-C ends it earlier",
           command.object.c_str(), wave.push.x(), wave.push.y(), wave.push.z(), wave.acceleration,
           seconds);
  ros::spin();
  ROS_INFO("the wave has ended");
}

}  // namespace

int main(int argc, char** argv) {
  std::optional<double> seconds;
  try {
    seconds = readSeconds(argc, argv);
  } catch (const std::runtime_error& error) {
    std::cerr << "push_wave: " << error.what() << " (see push_wave --help)\n";
    return 1;
  }
  if (!seconds) {
    std::cout << kUsage;
    return 0;
  }
  // Each line appears when it is written, in a pipe, too.
  std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);
  ros::init(argc, argv, "push_wave");
  ros::NodeHandle nh("~");
  try {
    run(nh, *seconds);
  } catch (const std::runtime_error& error) {
    ROS_FATAL("%s", error.what());
    return 1;
  }
}
