#include "command_check.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>
#include <tuple>

#include "scene/tree_reader.h"

namespace mass_spring {
namespace {

template <typename... Parts>
CommandResult refuse(Refusal refusal, const Parts&... parts) {
  std::ostringstream message;
  (message << ... << parts);
  return {refusal, message.str()};
}

CommandResult findObject(const std::string& name, const Model& model, const ModelObject*& object) {
  object = model.findObject(name);
  if (object) return {};
  std::string known;
  for (const ModelObject& o : model.objects) known += (known.empty() ? "" : ", ") + o.name;
  return refuse(Refusal::kUnknownObject, "object: got '", name, "', expected one of ", known);
}

/// Particles of an object to global numbers, each within range and none twice.
CommandResult resolve(const std::vector<std::uint32_t>& particles, const ModelObject& object,
                      std::vector<std::uint32_t>& global) {
  std::vector<char> seen(object.particle_count, 0);
  for (std::size_t k = 0; k < particles.size(); ++k) {
    if (particles[k] >= object.particle_count) {
      return refuse(Refusal::kBadIndex, "particles[", k, "]: got ", particles[k],
                    ", expected 0 to ", object.particle_count - 1, " (object ", object.name, ")");
    }
    if (seen[particles[k]]) {
      return refuse(Refusal::kBadIndex, "particles[", k, "]: got ", particles[k],
                    " a second time, expected each particle once");
    }
    seen[particles[k]] = 1;
    global.push_back(object.first_particle + particles[k]);
  }
  return {};
}

/// The particles of an object within a radius of a point; with radius 0 the nearest one.
CommandResult resolve(const Eigen::Vector3d& point, double radius, const ModelObject& object,
                      const Vectors& positions, std::vector<std::uint32_t>& global) {
  double nearest = std::numeric_limits<double>::infinity();
  std::uint32_t nearest_particle = object.first_particle;
  for (std::uint32_t p = object.first_particle; p < object.first_particle + object.particle_count;
       ++p) {
    const double distance = (positions.col(p) - point).stableNorm();
    if (distance < nearest) {
      nearest = distance;
      nearest_particle = p;
    }
    if (radius > 0.0 && distance <= radius) global.push_back(p);
  }
  if (radius == 0.0) global.push_back(nearest_particle);
  if (global.empty()) {
    return refuse(Refusal::kBadValue, "radius: got ", radius, " m, expected at least ", nearest,
                  " m, the distance of the nearest particle of ", object.name);
  }
  return {};
}

CommandResult notFinite(const char* field) {
  return refuse(Refusal::kNotFinite, field, ": got NaN or infinity, expected finite numbers (m)");
}

CommandResult checkFinite(const Pose& target) {
  if (!target.position.allFinite()) return notFinite("target.position");
  if (!target.orientation.coeffs().allFinite()) return notFinite("target.orientation");
  const double norm = target.orientation.coeffs().stableNorm();
  if (!(std::abs(norm - 1.0) <= 1e-3)) {
    return refuse(Refusal::kBadValue, "target.orientation: got a quaternion of length ", norm,
                  ", expected one of unit length");
  }
  return {};
}

/// @param way  m, from the start
CommandResult checkExtent(const char* field, const std::string& what, double way,
                          const Limits& limits) {
  if (way <= limits.max_extent) return {};
  return refuse(Refusal::kLimit, field, ": got ", way, " m from the start of ", what,
                ", expected at most ", limits.max_extent, " m (limits.max_extent)");
}

CommandResult checkSpeed(const char* field, const std::string& what, double speed,
                         const Limits& limits) {
  if (speed <= limits.max_speed) return {};
  return refuse(Refusal::kLimit, field, ": got ", speed, " m/s for ", what, ", expected at most ",
                limits.max_speed, " m/s (limits.max_speed)");
}

std::string nameOf(Eigen::Index particle, const Model& model) {
  const auto number = static_cast<std::uint32_t>(particle);
  const ModelObject& object = model.objectOf(number);
  return "particle " + std::to_string(number - object.first_particle) + " of " + object.name;
}

}  // namespace

CommandResult checkForce(const ForceCommand& command, const Model& model, const Limits& limits,
                         std::vector<std::uint32_t>& particles) {
  for (std::size_t k = 0; k < command.forces.size(); ++k) {
    if (!command.forces[k].allFinite()) {
      return refuse(Refusal::kNotFinite, "forces[", k, "]: got ", command.forces[k].transpose(),
                    ", expected finite numbers (N)");
    }
  }
  if (!std::isfinite(command.duration)) {
    return refuse(Refusal::kNotFinite, "duration: got ", command.duration,
                  ", expected a finite number (s)");
  }
  const ModelObject* object = nullptr;
  CommandResult result = findObject(command.object, model, object);
  if (!result.accepted()) return result;

  particles.clear();
  if (command.particles.empty()) {
    particles.resize(object->particle_count);
    std::iota(particles.begin(), particles.end(), object->first_particle);
  } else {
    result = resolve(command.particles, *object, particles);
    if (!result.accepted()) return result;
  }
  if (command.forces.size() != 1 && command.forces.size() != particles.size()) {
    return refuse(Refusal::kBadLength, "forces: got ", command.forces.size(),
                  " vectors, expected 1 or ", particles.size(), " (one per particle)");
  }
  for (std::size_t k = 0; k < command.forces.size(); ++k) {
    // stableNorm: the plain one overflows to infinity above 1e154 and underflows below 1e-154.
    const double force = command.forces[k].stableNorm();
    if (force > limits.max_force) {
      return refuse(Refusal::kLimit, "forces[", k, "]: got ", force, " N, expected at most ",
                    limits.max_force, " N (limits.max_force)");
    }
  }
  return result;
}

CommandResult checkPin(const PinCommand& command, const Model& model, const Vectors& positions,
                       std::vector<std::uint32_t>& particles) {
  if (CommandResult result = checkFinite(command.target); !result.accepted()) return result;
  if (!command.point.allFinite()) return notFinite("point");
  if (!std::isfinite(command.radius)) return notFinite("radius");
  if (command.name.empty()) {
    return refuse(Refusal::kBadValue, "name: got '', expected the name of a pin");
  }
  if (command.action != PinCommand::Action::kAdd) return {};
  if (!isName(command.name)) {
    return refuse(Refusal::kBadValue, "name: got '", command.name, "', expected ", kNameRule);
  }

  const ModelObject* object = nullptr;
  CommandResult result = findObject(command.object, model, object);
  if (!result.accepted()) return result;
  if (command.radius < 0.0) {
    return refuse(Refusal::kBadValue, "radius: got ", command.radius, " m, expected a number >= 0");
  }
  particles.clear();
  result = command.particles.empty()
               ? resolve(command.point, command.radius, *object, positions, particles)
               : resolve(command.particles, *object, particles);
  if (!result.accepted() || command.here) return result;
  // The particles stay where they are, in the axes of the target.
  return checkExtent(
      "target.position", nameOf(particles.front(), model),
      (command.target.position - model.start.positions.col(particles.front())).stableNorm(),
      model.limits);
}

CommandResult checkPinTarget(const Pin& pin, const Pose& target, const Model& model,
                             const Vectors& positions, double step) {
  for (std::size_t k = 0; k < pin.particles.size(); ++k) {
    const Eigen::Index i = pin.particles[k];
    const Eigen::Vector3d place = target.position + target.orientation * pin.offsets[k];
    const std::string name = nameOf(i, model);
    const double way = (place - model.start.positions.col(i)).stableNorm();
    const double speed = (place - positions.col(i)).stableNorm() / step;
    if (CommandResult result = checkExtent("target", name, way, model.limits); !result.accepted()) {
      return result;
    }
    if (CommandResult result = checkSpeed("target", name, speed, model.limits);
        !result.accepted()) {
      return result;
    }
  }
  return {};
}

CommandResult checkState(const Vectors& positions, const Vectors& velocities, const Model& model,
                         const Pins& pins, double step) {
  for (const auto& [field, values, unit] :
       {std::tuple("positions", &positions, "m"), std::tuple("velocities", &velocities, "m/s")}) {
    if (values->cols() != model.particleCount()) {
      return refuse(Refusal::kBadLength, field, ": got ", values->size(), " numbers, expected ",
                    3 * model.particleCount(), ", 3 per particle");
    }
    for (Eigen::Index k = 0; k < values->size(); ++k) {
      if (std::isfinite(values->data()[k])) continue;
      return refuse(Refusal::kNotFinite, field, "[", k, "]: got ", values->data()[k],
                    ", expected a finite number (", unit, ")");
    }
  }
  for (Eigen::Index i = 0; i < positions.cols(); ++i) {
    const double way = (positions.col(i) - model.start.positions.col(i)).stableNorm();
    const double speed = velocities.col(i).stableNorm();
    if (way <= model.limits.max_extent && speed <= model.limits.max_speed) continue;
    const std::string name = nameOf(i, model);
    const CommandResult result = checkExtent("positions", name, way, model.limits);
    return result.accepted() ? checkSpeed("velocities", name, speed, model.limits) : result;
  }
  for (const auto& [name, pin] : pins.all()) {
    CommandResult result = checkPinTarget(pin, pin.target, model, positions, step);
    if (result.accepted()) continue;
    result.message = "positions: pin " + name + " would not take them to its " + result.message;
    return result;
  }
  return {};
}

CommandResult checkShape(const ShapeCommand& command, const Model& model, const State& state,
                         double step) {
  if (CommandResult result = checkFinite(command.target); !result.accepted()) return result;
  if (!std::isfinite(command.duration)) return notFinite("duration");
  if (command.duration < 0.0) {
    return refuse(Refusal::kBadValue, "duration: got ", command.duration,
                  " s, expected a number >= 0");
  }
  if (const auto index = model.findShape(command.name)) {
    const Shape& shape = model.shapes[*index];
    const std::string what = "shape " + command.name;
    const double way = (command.target.position - shape.start().position).stableNorm();
    const CommandResult result = checkExtent("target", what, way, model.limits);
    if (!result.accepted()) return result;
    const Pose from = state.effects.shapes[*index].at(state.time);
    const RigidMotion motion(from, command.target, state.time, std::max(command.duration, step));
    const double radius = shape.radius().value_or(
        (state.positions.colwise() - from.position).colwise().norm().maxCoeff());
    return checkSpeed("target", what, motion.velocity().norm() + radius * motion.spin().norm(),
                      model.limits);
  }
  std::string known;
  for (const Shape& shape : model.shapes) known += (known.empty() ? "" : ", ") + shape.name();
  return refuse(Refusal::kUnknownShape, "name: got '", command.name,
                "', expected one of the shapes of contact: ", known.empty() ? "none" : known);
}

}  // namespace mass_spring
