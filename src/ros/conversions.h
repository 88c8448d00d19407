#pragma once

#include <mass_spring_sim/AppliedCommand.h>
#include <mass_spring_sim/Contacts.h>
#include <mass_spring_sim/ForceCommand.h>
#include <mass_spring_sim/ParticleStates.h>
#include <mass_spring_sim/PinCommand.h>
#include <mass_spring_sim/PinStates.h>
#include <mass_spring_sim/ShapeCommand.h>
#include <mass_spring_sim/Topology.h>

#include <Eigen/Geometry>
#include <functional>
#include <set>
#include <string>

#include "mass_spring_sim/command.h"
#include "mass_spring_sim/model.h"
#include "mass_spring_sim/simulation.h"
#include "mass_spring_sim/state.h"

namespace mass_spring {

/// Finds the pose of a frame in the scene's frame; "" is the scene's frame itself.
/// @throws tf2::TransformException if it is not known
using FrameLookup = std::function<Eigen::Isometry3d(const std::string& frame_id)>;

/// Translates a command and takes it to the scene's frame. Refuses what the simulation cannot see
/// or cannot name: values that are not finite, unknown frames, bad quaternions, unknown actions.
CommandResult toCommand(const mass_spring_sim::ForceCommand& message, const FrameLookup& lookup,
                        ForceCommand& command);
CommandResult toCommand(const mass_spring_sim::PinCommand& message, const FrameLookup& lookup,
                        PinCommand& command);
CommandResult toCommand(const mass_spring_sim::ShapeCommand& message, const FrameLookup& lookup,
                        ShapeCommand& command);

/// A command of the timeline, in the scene's frame; fills kind and force, pin or shape.
mass_spring_sim::AppliedCommand toMessage(const Command& command);

// The headers are left to the caller.
mass_spring_sim::ParticleStates toMessage(const State& state);
mass_spring_sim::Topology toMessage(const Model& model);

// Between steps; the header is left to the caller.
mass_spring_sim::PinStates pinStates(const Simulation& simulation);
/// @param simulation  with contact
/// @param stale       names of shapes whose frames are lost
mass_spring_sim::Contacts contacts(const Simulation& simulation,
                                   const std::set<std::string>& stale);

}  // namespace mass_spring
