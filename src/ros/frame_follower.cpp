#include "frame_follower.h"

#include <ros/console.h>

#include "effects/contact.h"

namespace mass_spring {

namespace {

const ros::Duration kLost(1.0);

bool same(const Pose& a, const Pose& b) {
  return a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs();
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
  const ros::Time now = ros::Time::now();
  leadShapes(simulation, now, commands);
  leadPins(simulation, now, commands);
  return commands;
}

void FrameFollower::leadShapes(const Simulation& simulation, const ros::Time& now,
                               std::vector<Command>& commands) {
  const auto& contact = simulation.scene().effects.contact;
  if (!contact) return;
  for (const ContactShape& shape : contact->shapes) {
    if (shape.follow_frame.empty()) continue;
    const auto frame = find(shape.follow_frame, "shape", shape.name, now, stale_shapes_);
    if (!frame) continue;
    const Shape& body = *simulation.model().contact->find(shape.name);
    Pose target;
    target.position = frame->position + frame->orientation * body.start().position;
    target.orientation = frame->orientation * body.start().orientation;
    if (!same(target, body.motion().target())) {
      commands.push_back(ShapeCommand{shape.name, target, 0.0});
    }
  }
}

void FrameFollower::leadPins(const Simulation& simulation, const ros::Time& now,
                             std::vector<Command>& commands) {
  for (const auto& [name, pin] : simulation.pins().all()) {
    if (pin.follow_frame.empty()) continue;
    const auto frame = find(pin.follow_frame, "pin", name, now, stale_pins_);
    if (!frame) continue;
    PinCommand command;
    command.name = name;
    command.follow_frame = pin.follow_frame;
    command.target = *frame;
    const auto led = led_.find(name);
    if (led != led_.end() && same(led->second, pin.target)) {
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
    led_[name] = *frame;
    commands.push_back(std::move(command));
  }
  const auto& pins = simulation.pins().all();
  forgetOthers(pins, led_, [](const auto& entry) { return entry.first; });
  forgetOthers(pins, stale_pins_, [](const std::string& name) { return name; });
}

std::optional<Pose> FrameFollower::find(const std::string& frame, const char* kind,
                                        const std::string& name, const ros::Time& now,
                                        std::set<std::string>& stale) {
  std::string lost;
  try {
    const Frames::Placed found = frames_.find(frame);
    const ros::Duration age = now - found.stamp;
    if (found.stamp.isZero() || age <= kLost) {
      if (stale.erase(name) > 0) {
        ROS_INFO_STREAM("The " << kind << ' ' << name << " follows its frame " << frame << '.');
      }
      const Pose heard{found.pose.translation(),
                       Eigen::Quaterniond(found.pose.linear()).normalized()};
      return motions_[frame].follow(heard, found.stamp, now);
    }
    lost = "last heard of " + std::to_string(age.toSec()) + " s ago";
  } catch (const tf2::TransformException& error) {
    lost = error.what();
  }
  if (stale.insert(name).second) {
    ROS_WARN_STREAM("The " << kind << ' ' << name << " stays where it is: its frame " << frame
                           << " is lost: " << lost);
  }
  return std::nullopt;
}

}  // namespace mass_spring
