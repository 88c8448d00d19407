#pragma once

#include "mass_spring_sim/command.h"
#include "mass_spring_sim/model.h"
#include "mass_spring_sim/scene.h"

namespace mass_spring {

/// Checks all of a force command before any of it takes effect.
/// @param particles  on acceptance: the global numbers it acts on
CommandResult checkForce(const ForceCommand& command, const Model& model, const Limits& limits,
                         std::vector<std::uint32_t>& particles);

/// The same for a pin command; whether its pin and particles are free is for the pins to say.
/// @param positions  where the particles are now, for a pin given by point and radius
/// @param particles  on acceptance of kAdd: the global numbers it holds, not empty
CommandResult checkPin(const PinCommand& command, const Model& model, const Vectors& positions,
                       std::vector<std::uint32_t>& particles);

/// A state that is to be put in place.
CommandResult checkState(const Vectors& positions, const Vectors& velocities, const Model& model);

/// The same for a command to a shape.
CommandResult checkShape(const ShapeCommand& command, const Model& model);

}  // namespace mass_spring
