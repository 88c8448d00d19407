#pragma once

#include "mass_spring_sim/command.h"
#include "mass_spring_sim/model.h"
#include "mass_spring_sim/pins.h"
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

/// Whether a pin may be led to a target within the next step: no particle that it holds may get
/// faster than limits.max_speed, or farther from its start than limits.max_extent.
/// @param step  s
CommandResult checkPinTarget(const Pin& pin, const Pose& target, const Model& model,
                             const Vectors& positions, double step);

/// A state that is to be put in place, and that the pins take to themselves in the next step [s].
CommandResult checkState(const Vectors& positions, const Vectors& velocities, const Model& model,
                         const Pins& pins, double step);

/// The same for a command to a shape, no place of which may get faster than limits.max_speed. A
/// plane has places where particles are.
/// @param state  before the step that it begins with
CommandResult checkShape(const ShapeCommand& command, const Model& model, const State& state,
                         double step);

}  // namespace mass_spring
