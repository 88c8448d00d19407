#pragma once

#include <ros/node_handle.h>

#include <memory>
#include <string>
#include <vector>

#include "mass_spring_sim/simulation.h"

namespace mass_spring {

/// The scene that the parameters of a node handle's namespace describe, ready to run. Paths of
/// files in it are relative to the file that the parameter `scene_file` names. From any thread.
/// @param problems  one per line of the answer to the user; filled if the scene is refused
/// @return nullptr if it is refused
std::shared_ptr<Simulation> loadSimulation(const ros::NodeHandle& nh,
                                           std::vector<std::string>& problems);

/// Whether the node is to follow the /clock of others.
/// @param problems  likewise
bool loadExternalClock(const ros::NodeHandle& nh, std::vector<std::string>& problems);

}  // namespace mass_spring
