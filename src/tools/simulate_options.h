#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mass_spring_sim/scene.h"
#include "tools/command_line.h"

namespace mass_spring {

/// The arguments of `simulate`.
struct SimulateOptions {
  std::string scene;                     ///< a file
  double duration = 0.0;                 ///< s, > 0; 0 = only check the scene
  std::vector<std::string> assignments;  ///< PATH=VALUE, in order of effect
  std::uint64_t every = 1;               ///< steps between states in the output, >= 1
  std::string output;                    ///< CSV file; "" = none
  std::string report;                    ///< JSON file; "" = none
};

/// Reads the arguments; answers --help on standard output and exits.
/// @throws ArgumentError  one line that names the argument
SimulateOptions readSimulateOptions(int argc, const char* const* argv);

/// The scene of a file with assignments PATH=VALUE made, in their order.
/// @throws SceneError
Scene readSceneWith(const std::string& file, const std::vector<std::string>& assignments);

/// Whole steps that cover the duration; a rounding error of a product that should be an integer
/// makes no step of its own.
/// @throws ArgumentError  more than a counter of steps and a double of time can tell apart
std::uint64_t stepCount(double duration, double rate);

}  // namespace mass_spring
