#include "scene/command_reader.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "scene/object_parts.h"
#include "scene/scalar.h"

namespace mass_spring {
namespace {

std::optional<std::uint32_t> particleCountOf(const ParticleCounts& counts,
                                             const std::string& object) {
  const auto entry = counts.find(object);
  return entry == counts.end() ? std::nullopt : entry->second;
}

/// @param particles  how many the forces act on, if that is known
void readForces(const Place& place, std::optional<std::size_t> particles, const Limits& limits,
                std::vector<Eigen::Vector3d>& forces) {
  const Tree::List* list = place.list("a list of forces, each a list of 3 finite numbers (N)");
  if (list == nullptr) return;
  if (list->empty() || (particles && list->size() != 1 && list->size() != *particles)) {
    std::string expected = "a list of 1 force";
    if (particles) expected += ", or of " + std::to_string(*particles) + ", one for each particle";
    return place.refuse(expected);
  }
  forces.resize(list->size());
  for (std::size_t i = 0; i < list->size(); ++i) {
    const Place force = place.element(i);
    if (!force.read(forces[i], anyNumber("N"))) continue;
    const double size = forces[i].stableNorm();
    if (size <= limits.max_force) continue;
    force.report("a force of " + formatNumber(size) + " N",
                 "at most " + formatNumber(limits.max_force) + " N (limits.max_force)");
  }
}

void readOrientation(const Place& place, Eigen::Quaterniond& orientation) {
  const std::string expected = "roll pitch yaw (rad), or a unit quaternion x y z w";
  if (!place.present()) return;
  const Tree::List* list = place.list(expected);
  if (list == nullptr) return;
  if (list->size() == 4) {
    if (!place.read(orientation.coeffs(), anyNumber(""))) return;
    const double norm = orientation.coeffs().stableNorm();
    if (!(std::abs(norm - 1.0) <= 1e-3)) return place.report("another length", expected);
    // One that is normal but for rounding is left alone, so that writing and reading it again gives
    // the same bits.
    if (std::abs(norm - 1.0) > 1e-15) orientation.normalize();
  } else {
    Eigen::Vector3d angles;
    if (!place.read(angles, anyNumber("rad"))) return;
    orientation = Eigen::Quaterniond(rotation(angles)).normalized();
  }
}

void readAddedPin(MapReader& keys, const ParticleCounts& counts, PinCommand& command) {
  readObjectName(keys.optional("object"), counts, command.object);
  const Place particles = keys.optional("particles");
  const Place point = keys.optional("point");
  const Place radius = keys.optional("radius");
  const Place target = keys.optional("target");
  const Place orientation = keys.optional("orientation");

  const bool has_particles =
      readParticles(particles, particleCountOf(counts, command.object), command.particles);
  readPosition(point, command.point);
  radius.read(command.radius, atLeastZero("m"));
  if (!command.particles.empty() && point.present()) {
    point.report("particles as well", "either particles or point");
  } else if (has_particles && command.particles.empty() && !point.present()) {
    particles.refuse("a list of particle indices, or point instead");
  } else if (!particles.present() && !point.present()) {
    particles.report("nothing", "a list of particle indices, or point instead");
  } else if (radius.present() && !point.present()) {
    radius.report("a radius without a point", "point as well");
  }

  command.here = !target.present();
  readPosition(target, command.target.position);
  readOrientation(orientation, command.target.orientation);
  if (orientation.present() && !target.present()) {
    orientation.report("an orientation without a target", "target as well");
  }
}

}  // namespace

void readForceCommand(const Place& place, const ParticleCounts& counts, const Limits& limits,
                      ForceCommand& command) {
  MapReader keys(place, "a map with object, particles, forces, duration");
  readObjectName(keys.optional("object"), counts, command.object);
  const auto count = particleCountOf(counts, command.object);
  const Place particles = keys.optional("particles");
  const bool all = !particles.present() || (readParticles(particles, count, command.particles) &&
                                            command.particles.empty());
  // Bad particles say nothing about how many forces are wanted.
  std::optional<std::size_t> addressed;
  if (all) {
    if (count) addressed = *count;
  } else if (!command.particles.empty()) {
    addressed = command.particles.size();
  }
  readForces(keys.required("forces"), addressed, limits, command.forces);
  keys.optional("duration").read(command.duration, anyNumber("s"));
  keys.optional("id").read(command.id, "a string");
  keys.refuseUnknown();
}

void readPinCommand(const Place& place, const ParticleCounts& counts, PinCommand& command) {
  static const std::vector<std::string> kActions = {"add", "move", "remove"};
  MapReader keys(place, "a map with action and name");
  std::size_t action = 0;
  if (!keys.required("action").read(action, kActions)) return;
  command.action = static_cast<PinCommand::Action>(action);
  if (command.action != PinCommand::Action::kRemove) {
    readFrame(keys.optional("follow_frame"), command.follow_frame);
  }
  const Place name = keys.required("name");
  if (name.read(command.name, kNameRule) && !isName(command.name)) name.refuse(kNameRule);
  if (command.action == PinCommand::Action::kAdd) {
    readAddedPin(keys, counts, command);
  } else if (command.action == PinCommand::Action::kMove) {
    readPosition(keys.required("target"), command.target.position);
    readOrientation(keys.optional("orientation"), command.target.orientation);
  }
  keys.refuseUnknown();
}

void readShapeCommand(const Place& place, const std::vector<std::string>* shapes,
                      ShapeCommand& command) {
  MapReader keys(place, "a map with name and target");
  const Place name = keys.required("name");
  if (name.read(command.name, kNameRule) && shapes != nullptr &&
      std::find(shapes->begin(), shapes->end(), command.name) == shapes->end()) {
    name.refuse(shapes->empty() ? "a shape of effects.contact, of which there is none"
                                : "a shape of effects.contact (" + listWords(*shapes) + ")");
  }
  readPosition(keys.required("target"), command.target.position);
  readOrientation(keys.optional("orientation"), command.target.orientation);
  keys.optional("duration").read(command.duration, atLeastZero("s"));
  keys.refuseUnknown();
}

void readClearCommand(const Place& place, ClearCommand& command) {
  std::size_t what = 0;
  if (place.read(what, {"forces", "pins"})) command.what = static_cast<ClearCommand::What>(what);
}

}  // namespace mass_spring
