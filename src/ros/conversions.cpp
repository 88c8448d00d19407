#include "conversions.h"

#include <sensor_msgs/point_cloud2_iterator.h>
#include <tf2/exceptions.h>

#include <algorithm>
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

geometry_msgs::Pose fromPose(const Pose& pose) {
  geometry_msgs::Pose message;
  message.position = fromVector<geometry_msgs::Point>(pose.position);
  message.orientation.w = pose.orientation.w();
  message.orientation.x = pose.orientation.x();
  message.orientation.y = pose.orientation.y();
  message.orientation.z = pose.orientation.z();
  return message;
}

Pose toPose(const geometry_msgs::Pose& message) {
  return {toVector(message.position), toQuaternion(message.orientation)};
}

geometry_msgs::Wrench fromWrench(const Wrench& wrench) {
  geometry_msgs::Wrench message;
  message.force = fromVector<geometry_msgs::Vector3>(wrench.force);
  message.torque = fromVector<geometry_msgs::Vector3>(wrench.torque);
  return message;
}

CommandResult notFinite(const std::string& field) {
  return {Refusal::kNotFinite, field + ": got NaN or infinity, expected a finite number"};
}

/// Makes the quaternion one of unit length; all zeros, the default of a message, is no rotation.
CommandResult normalize(Eigen::Quaterniond& quaternion) {
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
                        Eigen::Isometry3d& frame, const char* field = "header.frame_id") {
  try {
    frame = lookup(frame_id);
  } catch (const tf2::TransformException& error) {
    return {Refusal::kBadFrame, std::string(field) + ": got \"" + frame_id +
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
  if (auto length = normalize(orientation); !length.accepted()) return length;

  command.action = static_cast<PinCommand::Action>(message.action);
  command.name = message.name;
  // A pin that is let go goes nowhere: no frame that may be gone by now is asked for.
  if (command.action == PinCommand::Action::kRemove) return {};

  Eigen::Isometry3d frame;
  if (!message.follow_frame.empty()) {
    if (command.action == PinCommand::Action::kMove) {
      return {Refusal::kBadValue, "follow_frame: got \"" + message.follow_frame +
                                      "\" with MOVE, expected \"\": it belongs to ADD"};
    }
    if (auto found = findFrame(message.follow_frame, lookup, frame, "follow_frame");
        !found.accepted()) {
      return found;
    }
  }
  if (auto found = findFrame(message.header.frame_id, lookup, frame); !found.accepted()) {
    return found;
  }
  command.object = message.object;
  command.particles = message.particles;
  command.point = frame * point;
  command.radius = message.radius;
  command.target.position = frame * position;
  command.target.orientation = (Eigen::Quaterniond(frame.linear()) * orientation).normalized();
  // Where the frame is, whoever leads the pin knows.
  command.here = message.here || !message.follow_frame.empty();
  command.follow_frame = message.follow_frame;
  return {};
}

CommandResult toCommand(const geometry_msgs::PoseStamped& message, const std::string& pin,
                        const FrameLookup& lookup, PinCommand& command) {
  mass_spring_sim::PinCommand move;
  move.header = message.header;
  move.action = mass_spring_sim::PinCommand::MOVE;
  move.name = pin;
  move.target = message.pose;
  return toCommand(move, lookup, command);
}

CommandResult toCommand(const mass_spring_sim::ShapeCommand& message, const FrameLookup& lookup,
                        ShapeCommand& command) {
  const Eigen::Vector3d position = toVector(message.target.position);
  Eigen::Quaterniond orientation = toQuaternion(message.target.orientation);
  if (!position.allFinite()) return notFinite("target.position");
  if (!orientation.coeffs().allFinite()) return notFinite("target.orientation");
  if (!std::isfinite(message.duration)) return notFinite("duration");
  if (auto length = normalize(orientation); !length.accepted()) return length;
  Eigen::Isometry3d frame;
  if (auto found = findFrame(message.header.frame_id, lookup, frame); !found.accepted()) {
    return found;
  }
  command.name = message.name;
  command.target.position = frame * position;
  command.target.orientation = (Eigen::Quaterniond(frame.linear()) * orientation).normalized();
  command.duration = message.duration;
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
  } else if (const auto* pin = std::get_if<PinCommand>(&command)) {
    message.kind = mass_spring_sim::AppliedCommand::PIN;
    message.pin.action = static_cast<std::uint8_t>(pin->action);
    message.pin.name = pin->name;
    message.pin.object = pin->object;
    message.pin.particles = pin->particles;
    message.pin.point = fromVector<geometry_msgs::Point>(pin->point);
    message.pin.radius = pin->radius;
    message.pin.target = fromPose(pin->target);
    message.pin.here = pin->here;
    message.pin.follow_frame = pin->follow_frame;
  } else if (const auto* shape = std::get_if<ShapeCommand>(&command)) {
    message.kind = mass_spring_sim::AppliedCommand::SHAPE;
    message.shape.name = shape->name;
    message.shape.target = fromPose(shape->target);
    message.shape.duration = shape->duration;
  } else {
    message.kind = std::get<ClearCommand>(command).what == ClearCommand::What::kForces
                       ? mass_spring_sim::AppliedCommand::CLEAR_FORCES
                       : mass_spring_sim::AppliedCommand::CLEAR_PINS;
  }
  return message;
}

Command toCommand(const mass_spring_sim::AppliedCommand& message) {
  using Message = mass_spring_sim::AppliedCommand;
  if (message.kind == Message::FORCE) {
    ForceCommand force;
    force.id = message.force.id;
    force.object = message.force.object;
    force.particles = message.force.particles;
    for (const auto& vector : message.force.forces) force.forces.push_back(toVector(vector));
    force.duration = message.force.duration;
    return force;
  }
  if (message.kind == Message::PIN) {
    PinCommand pin;
    pin.action = static_cast<PinCommand::Action>(message.pin.action);
    pin.name = message.pin.name;
    pin.object = message.pin.object;
    pin.particles = message.pin.particles;
    pin.point = toVector(message.pin.point);
    pin.radius = message.pin.radius;
    pin.target = toPose(message.pin.target);
    pin.here = message.pin.here;
    pin.follow_frame = message.pin.follow_frame;
    return pin;
  }
  if (message.kind == Message::SHAPE) {
    return ShapeCommand{message.shape.name, toPose(message.shape.target), message.shape.duration};
  }
  return ClearCommand{message.kind == Message::CLEAR_FORCES ? ClearCommand::What::kForces
                                                            : ClearCommand::What::kPins};
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

geometry_msgs::Wrench wrenchIn(const Pose& frame, Wrench wrench, const Eigen::Vector3d& about) {
  const Eigen::Quaterniond to_frame = frame.orientation.conjugate();
  wrench.torque += (about - frame.position).cross(wrench.force);
  return fromWrench({to_frame * wrench.force, to_frame * wrench.torque});
}

mass_spring_sim::PinStates pinStates(const Simulation& simulation,
                                     const std::map<std::string, Wrench>& wrenches,
                                     const std::set<std::string>& stale) {
  mass_spring_sim::PinStates message;
  for (const auto& [name, pin] : simulation.pins().all()) {
    mass_spring_sim::PinState& state = message.pins.emplace_back();
    state.name = name;
    state.particles = pin.particles;
    state.target = fromPose(pin.target);
    state.wrench = fromWrench(wrenches.at(name));
    state.stale = stale.count(name) > 0;
    for (std::size_t k = 0; k < pin.particles.size(); ++k) {
      const Eigen::Vector3d meant = pin.target.position + pin.target.orientation * pin.offsets[k];
      const Eigen::Vector3d is = simulation.state().positions.col(pin.particles[k]);
      state.position_error = std::max(state.position_error, (is - meant).norm());
    }
  }
  return message;
}

mass_spring_sim::Contacts contacts(const Simulation& simulation,
                                   const std::map<std::string, Wrench>& wrenches,
                                   const std::set<std::string>& stale) {
  mass_spring_sim::Contacts message;
  const State& state = simulation.state();
  message.step = state.step;
  message.sim_time = state.time;
  const std::vector<Shape>& shapes = simulation.model().shapes;
  for (std::size_t s = 0; s < shapes.size(); ++s) {
    const Shape& shape = shapes[s];
    mass_spring_sim::ShapeState& entry = message.shapes.emplace_back();
    entry.name = shape.name();
    entry.pose = fromPose(state.effects.shapes[s].at(state.time));
    entry.wrench = fromWrench(wrenches.at(shape.name()));
    entry.stale = stale.count(shape.name()) > 0;
  }
  for (const Touch& touch : simulation.touches()) {
    mass_spring_sim::Contact& contact = message.contacts.emplace_back();
    contact.particle = touch.particle;
    contact.shape = touch.shape;
    contact.position = fromVector<geometry_msgs::Point>(state.positions.col(touch.particle));
    contact.force = fromVector<geometry_msgs::Vector3>(touch.force);
  }
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

sensor_msgs::PointCloud2 pointCloud(const Model& model, const State& state) {
  sensor_msgs::PointCloud2 cloud;
  cloud.height = 1;
  sensor_msgs::PointCloud2Modifier modifier(cloud);
  using Field = sensor_msgs::PointField;
  modifier.setPointCloud2Fields(8, "x", 1, Field::FLOAT32, "y", 1, Field::FLOAT32, "z", 1,
                                Field::FLOAT32, "vx", 1, Field::FLOAT32, "vy", 1, Field::FLOAT32,
                                "vz", 1, Field::FLOAT32, "strain", 1, Field::FLOAT32, "id", 1,
                                Field::UINT32);
  const std::uint32_t count = model.particleCount();
  modifier.resize(count);
  cloud.is_dense = true;

  std::vector<float> strains(count, 0.0F);
  for (const Spring& spring : model.springs) {
    const auto s = static_cast<float>(strain(spring, state.positions));
    for (const std::uint32_t end : {spring.i, spring.j}) {
      if (std::abs(s) > std::abs(strains[end])) strains[end] = s;
    }
  }
  sensor_msgs::PointCloud2Iterator<float> values(cloud, "x");
  sensor_msgs::PointCloud2Iterator<std::uint32_t> id(cloud, "id");
  for (std::uint32_t particle = 0; particle < count; ++particle, ++values, ++id) {
    for (int axis = 0; axis < 3; ++axis) {
      values[axis] = static_cast<float>(state.positions(axis, particle));
      values[3 + axis] = static_cast<float>(state.velocities(axis, particle));
    }
    values[6] = strains[particle];
    *id = particle;
  }
  return cloud;
}

}  // namespace mass_spring
