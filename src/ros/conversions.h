#pragma once

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/Wrench.h>
#include <mass_spring_sim/AppliedCommand.h>
#include <mass_spring_sim/Contacts.h>
#include <mass_spring_sim/ForceCommand.h>
#include <mass_spring_sim/ParticleStates.h>
#include <mass_spring_sim/PinCommand.h>
#include <mass_spring_sim/PinStates.h>
#include <mass_spring_sim/ShapeCommand.h>
#include <mass_spring_sim/Topology.h>
#include <sensor_msgs/PointCloud2.h>

#include <Eigen/Geometry>
#include <functional>
#include <map>
#include <set>
#include <string>

#include "mass_spring_sim/command.h"
#include "mass_spring_sim/measures.h"
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
/// A new target for the pin of that name.
CommandResult toCommand(const geometry_msgs::PoseStamped& message, const std::string& pin,
                        const FrameLookup& lookup, PinCommand& command);

/// A command in the scene's frame; fills kind and what belongs to it.
mass_spring_sim::AppliedCommand toMessage(const Command& command);
/// The inverse, bit for bit.
/// @param message  of a kind that is a command: none of SET_STATE, RESET, RELOAD
Command toCommand(const mass_spring_sim::AppliedCommand& message);

// The headers are left to the caller.
mass_spring_sim::ParticleStates toMessage(const State& state);
mass_spring_sim::Topology toMessage(const Model& model);
/// x y z vx vy vz strain as float32, id as uint32. The strain of a particle is that of its springs
/// that is largest in magnitude; 0 without springs.
sensor_msgs::PointCloud2 pointCloud(const Model& model, const State& state);

// Between steps; the header is left to the caller.
/// @param wrenches  on the pins, on the shapes
/// @param stale     names of pins, of shapes, whose frames are lost
mass_spring_sim::PinStates pinStates(const Simulation& simulation,
                                     const std::map<std::string, Wrench>& wrenches,
                                     const std::set<std::string>& stale);
/// A wrench about a point, in the axes of the scene, as a sensor in a frame would tell it: about
/// the frame's origin and in its axes.
geometry_msgs::Wrench wrenchIn(const Pose& frame, Wrench wrench, const Eigen::Vector3d& about);
/// @param simulation  with contact
mass_spring_sim::Contacts contacts(const Simulation& simulation,
                                   const std::map<std::string, Wrench>& wrenches,
                                   const std::set<std::string>& stale);

}  // namespace mass_spring
