#pragma once

#include "mass_spring_sim/command.h"
#include "mass_spring_sim/scene.h"
#include "scene/references.h"
#include "scene/tree_reader.h"

namespace mass_spring {

/// {object, particles, forces, duration, id} of a timeline.
void readForceCommand(const Place& place, const ParticleCounts& counts, const Limits& limits,
                      ForceCommand& command);

/// {action: add, name, object, particles or point and radius, target, orientation},
/// {action: move, name, target, orientation} or {action: remove, name} of a timeline. The
/// orientation is roll pitch yaw, or a quaternion x y z w. A pin that is added without a target is
/// made where its particles are.
void readPinCommand(const Place& place, const ParticleCounts& counts, PinCommand& command);

/// {name, target, orientation, duration} of a timeline.
/// @param shapes  the names that there are; nullptr if that is not known
void readShapeCommand(const Place& place, const std::vector<std::string>* shapes,
                      ShapeCommand& command);

/// forces or pins, of a timeline.
void readClearCommand(const Place& place, ClearCommand& command);

}  // namespace mass_spring
