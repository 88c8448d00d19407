#include "frame_follower.h"

#include <ros/console.h>

#include <algorithm>

namespace mass_spring {

namespace {

const ros::Duration kLost(1.0);
constexpr std::chrono::seconds kPatience(1);

bool same(const Pose& a, const Pose& b) {
  return a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs();
}

bool isLast(const std::map<std::string, Pose>& led, const std::string& name, const Pose& target) {
  const auto last = led.find(name);
  return last != led.end() && same(last->second, target);
}

/// Of what moves along and turns at once, each may use half of limits.max_speed, but for rounding
/// [m/s].
double fastestOf(const Simulation& simulation) {
  return 0.499 * simulation.scene().limits.max_speed;
}

/// Erases those for which there is no pin (any more).
template <class Names, class NameOf>
void forgetOthers(const std::map<std::string, Pin>& pins, Names& names, NameOf name_of) {
  for (auto entry = names.begin(); entry != names.end();) {
    entry = pins.count(name_of(*entry)) > 0 ? std::next(entry) : names.erase(entry);
  }
}

}  // namespace

std::vector<Command> FrameFollower::lead(const Simulation& simulation) {
  std::vector<Command> commands;
  places_.clear();
  leadShapes(simulation, commands);
  leadPins(simulation, commands);
  return commands;
}

bool FrameFollower::leads(const std::string& name, const Pin& pin) const {
  return isLast(led_pins_, name, pin.target);
}

bool FrameFollower::leads(const Shape& shape, const RigidMotion& motion) const {
  return isLast(led_shapes_, shape.name(), motion.target());
}

void FrameFollower::leadShapes(const Simulation& simulation, std::vector<Command>& commands) {
  const auto& contact = simulation.scene().effects.contact;
  if (!contact) return;
  const State& state = simulation.state();
  for (std::size_t s = 0; s < contact->shapes.size(); ++s) {
    const ContactShape& shape = contact->shapes[s];
    if (shape.follow_frame.empty()) continue;
    const auto frame = find(shape.follow_frame, "shape", shape.name, simulation, stale_shapes_);
    if (!frame) continue;
    const Shape& body = simulation.model().shapes[s];
    const RigidMotion& motion = state.effects.shapes[s];
    Pose target;
    target.position = frame->position + frame->orientation * body.start().position;
    target.orientation = frame->orientation * body.start().orientation;
    led_shapes_[shape.name] = target;
    if (same(target, motion.target())) continue;
    const Pose now = motion.at(state.time);
    const double radius = body.radius().value_or(
        (state.positions.colwise() - now.position).colwise().norm().maxCoeff());
    const double way = std::max((target.position - now.position).norm(),
                                radius * now.orientation.angularDistance(target.orientation));
    const double duration = way / fastestOf(simulation);
    commands.push_back(
        ShapeCommand{shape.name, target, duration > simulation.stepSize() ? duration : 0.0});
  }
}

void FrameFollower::leadPins(const Simulation& simulation, std::vector<Command>& commands) {
  for (const auto& [name, pin] : simulation.pins().all()) {
    if (pin.follow_frame.empty()) continue;
    const auto frame = find(pin.follow_frame, "pin", name, simulation, stale_pins_);
    if (!frame) continue;
    PinCommand command;
    command.name = name;
    command.follow_frame = pin.follow_frame;
    command.target = *frame;
    if (leads(name, pin)) {
      if (same(*frame, pin.target)) continue;
      command.action = PinCommand::Action::kMove;
    } else {
      PinCommand remove;
      remove.action = PinCommand::Action::kRemove;
      remove.name = name;
      commands.push_back(remove);
      const ModelObject& object = simulation.model().objectOf(pin.particles.front());
      command.object = object.name;
      for (std::uint32_t particle : pin.particles) {
        command.particles.push_back(particle - object.first_particle);
      }
    }
    led_pins_[name] = *frame;
    commands.push_back(std::move(command));
  }
  const auto& pins = simulation.pins().all();
  forgetOthers(pins, led_pins_, [](const auto& entry) { return entry.first; });
  forgetOthers(pins, stale_pins_, [](const std::string& name) { return name; });
}

std::optional<Pose> FrameFollower::find(const std::string& frame, const char* kind,
                                        const std::string& name, const Simulation& simulation,
                                        std::set<std::string>& stale) {
  auto known = places_.find(frame);
  if (known == places_.end()) known = places_.emplace(frame, look(frame, simulation)).first;
  const Place& place = known->second;
  if (place.pose) {
    if (stale.erase(name) > 0) {
      ROS_INFO_STREAM("The " << kind << ' ' << name << " follows its frame " << frame << '.');
    }
  } else if (!place.awaited && stale.insert(name).second) {
    ROS_WARN_STREAM("The " << kind << ' ' << name << " stays where it is: its frame " << frame
                           << " is lost: " << place.problem);
  }
  return place.pose;
}

double FrameFollower::reach(const std::string& frame, const Simulation& simulation) const {
  double reach = 1e-3;
  for (const auto& [name, pin] : simulation.pins().all()) {
    if (pin.follow_frame != frame || !leads(name, pin)) continue;
    for (const Eigen::Vector3d& offset : pin.offsets) reach = std::max(reach, offset.norm());
  }
  return reach;
}

FrameFollower::Place FrameFollower::look(const std::string& frame, const Simulation& simulation) {
  Place place;
  const ros::Time now = ros::Time::now();
  try {
    const Frames::Placed found = frames_.find(frame);
    const ros::Duration age = now - found.stamp;
    if (found.stamp.isZero() || age <= kLost) {
      const Pose heard{found.pose.translation(),
                       Eigen::Quaterniond(found.pose.linear()).normalized()};
      const double fastest = fastestOf(simulation);
      place.pose = motions_[frame].follow(heard, found.stamp, now, simulation.stepSize(),
                                          {fastest, fastest / reach(frame, simulation)});
      return place;
    }
    place.problem = "last heard of " + std::to_string(age.toSec()) + " s ago";
  } catch (const tf2::TransformException& error) {
    place.problem = error.what();
  }
  const auto motion = motions_.find(frame);
  if (motion != motions_.end()) {
    motion->second.lose();
  } else {
    const Steady::time_point wall = Steady::now();
    place.awaited = wall < awaited_.emplace(frame, wall).first->second + kPatience;
  }
  return place;
}

}  // namespace mass_spring
