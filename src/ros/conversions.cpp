#include "conversions.h"

#include <tf2/exceptions.h>

#include <cmath>
#include <variant>

namespace mass_spring {

namespace {

constexpr double kQuaternionTolerance = 1e-3;

template <class Message>
Eigen::Vector3d toVector(const Message& message) {
  return {message.x, message.y, message.z};
}

template <class Message>
Message fromVector(const Eigen::Vector3d& vector) {
  Message message;
  message.x = vector.x();
  message.y = vector.y();
  message.z = vector.z();
  return message;
}

Eigen::Quaterniond toQuaternion(const geometry_msgs::Quaternion& message) {
  return {message.w, message.x, message.y, message.z};
}

CommandResult notFinite(const std::string& field) {
  return {Refusal::kNotFinite, field + ": got NaN or infinity, expected a finite number"};
}

/// Makes the quaternion one of unit length; all zeros, the default of a message, is no rotation.
CommandResult normalise(Eigen::Quaterniond& quaternion) {
  const double length = quaternion.norm();
  if (length == 0.0) {
    quaternion.setIdentity();
  } else if (std::abs(length - 1.0) <= kQuaternionTolerance) {
    quaternion.normalize();
  } else {
    return {Refusal::kBadValue, "target.orientation: got a quaternion of length " +
                                    std::to_string(length) + ", expected 1, or all zeros"};
  }
  return {};
}

CommandResult findFrame(const std::string& frame_id, const FrameLookup& lookup,
                        Eigen::Isometry3d& frame) {
  try {
    frame = lookup(frame_id);
  } catch (const tf2::TransformException& error) {
    return {Refusal::kBadFrame, "header.frame_id: got \"" + frame_id +
                                    "\", expected a frame that tf knows: " + error.what()};
  }
  return {};
}

}  // namespace

CommandResult toCommand(const mass_spring_sim::ForceCommand& message, const FrameLookup& lookup,
                        ForceCommand& command) {
  for (std::size_t i = 0; i < message.forces.size(); ++i) {
    if (!toVector(message.forces[i]).allFinite()) {
      return notFinite("forces[" + std::to_string(i) + "]");
    }
  }
  if (!std::isfinite(message.duration)) return notFinite("duration");

  Eigen::Isometry3d frame;
  if (auto found = findFrame(message.header.frame_id, lookup, frame); !found.accepted()) {
    return found;
  }
  command.id = message.id;
  command.object = message.object;
  command.particles = message.particles;
  command.forces.clear();
  command.forces.reserve(message.forces.size());
  for (const auto& force : message.forces) {
    command.forces.push_back(frame.linear() * toVector(force));
  }
  command.duration = message.duration;
  return {};
}

CommandResult toCommand(const mass_spring_sim::PinCommand& message, const FrameLookup& lookup,
                        PinCommand& command) {
  using Message = mass_spring_sim::PinCommand;
  const Eigen::Vector3d point = toVector(message.point);
  const Eigen::Vector3d position = toVector(message.target.position);
  Eigen::Quaterniond orientation = toQuaternion(message.target.orientation);
  if (!point.allFinite()) return notFinite("point");
  if (!std::isfinite(message.radius)) return notFinite("radius");
  if (!position.allFinite()) return notFinite("target.position");
  if (!orientation.coeffs().allFinite()) return notFinite("target.orientation");

  if (message.action > Message::REMOVE) {
    return {Refusal::kBadValue, "action: got " + std::to_string(message.action) +
                                    ", expected 0 (ADD), 1 (MOVE) or 2 (REMOVE)"};
  }
  if (!message.follow_frame.empty()) {
    return {Refusal::kBadFrame, "follow_frame: got \"" + message.follow_frame +
                                    "\", expected \"\": pins of this version do not follow frames"};
  }
  if (auto length = normalise(orientation); !length.accepted()) return length;

  command.action = static_cast<PinCommand::Action>(message.action);
  command.name = message.name;
  // A pin that is let go goes nowhere: no frame that may be gone by now is asked for.
  if (command.action == PinCommand::Action::kRemove) return {};

  Eigen::Isometry3d frame;
  if (auto found = findFrame(message.header.frame_id, lookup, frame); !found.accepted()) {
    return found;
  }
  command.object = message.object;
  command.particles = message.particles;
  command.point = frame * point;
  command.radius = message.radius;
  command.target.position = frame * position;
  command.target.orientation = (Eigen::Quaterniond(frame.linear()) * orientation).normalized();
  command.here = message.here;
  return {};
}

mass_spring_sim::AppliedCommand toMessage(const Command& command) {
  mass_spring_sim::AppliedCommand message;
  if (const auto* force = std::get_if<ForceCommand>(&command)) {
    message.kind = mass_spring_sim::AppliedCommand::FORCE;
    message.force.id = force->id;
    message.force.object = force->object;
    message.force.particles = force->particles;
    for (const Eigen::Vector3d& vector : force->forces) {
      message.force.forces.push_back(fromVector<geometry_msgs::Vector3>(vector));
    }
    message.force.duration = force->duration;
  } else {
    const auto& pin = std::get<PinCommand>(command);
    message.kind = mass_spring_sim::AppliedCommand::PIN;
    message.pin.action = static_cast<std::uint8_t>(pin.action);
    message.pin.name = pin.name;
    message.pin.object = pin.object;
    message.pin.particles = pin.particles;
    message.pin.point = fromVector<geometry_msgs::Point>(pin.point);
    message.pin.radius = pin.radius;
    message.pin.target.position = fromVector<geometry_msgs::Point>(pin.target.position);
    message.pin.target.orientation.w = pin.target.orientation.w();
    message.pin.target.orientation.x = pin.target.orientation.x();
    message.pin.target.orientation.y = pin.target.orientation.y();
    message.pin.target.orientation.z = pin.target.orientation.z();
    message.pin.here = pin.here;
  }
  return message;
}

mass_spring_sim::ParticleStates toMessage(const State& state) {
  const auto flat = [](const Vectors& vectors) {
    return std::vector<double>(vectors.data(), vectors.data() + vectors.size());
  };
  mass_spring_sim::ParticleStates message;
  message.step = state.step;
  message.sim_time = state.time;
  message.positions = flat(state.positions);
  message.velocities = flat(state.velocities);
  return message;
}

mass_spring_sim::Topology toMessage(const Model& model) {
  mass_spring_sim::Topology message;
  for (const ModelObject& object : model.objects) {
    message.objects.push_back(object.name);
    message.first_particle.push_back(object.first_particle);
    message.particle_count.push_back(object.particle_count);
  }
  message.masses.assign(model.masses.data(), model.masses.data() + model.masses.size());
  for (const Spring& spring : model.springs) {
    message.springs.insert(message.springs.end(), {spring.i, spring.j});
    message.spring_kind.push_back(static_cast<std::uint8_t>(spring.kind));
    message.rest_lengths.push_back(spring.rest_length);
    message.stiffnesses.push_back(spring.stiffness);
  }
  for (const auto& triangle : model.triangles) {
    message.triangles.insert(message.triangles.end(), triangle.begin(), triangle.end());
  }
  return message;
}

}  // namespace mass_spring
