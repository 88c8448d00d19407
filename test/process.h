#pragma once

#include <functional>
#include <string>
#include <vector>

namespace mass_spring {

/// What became of a program.
struct ProcessResult {
  int status = -1;  ///< exit status; 128 + signal if a signal ended it; -1 = it missed its deadline
  std::string out, err;
};

/// Where a program of this package lies: in the folder that the environment variable
/// MASS_SPRING_PROGRAM_FOLDER names, else where the build has put it.
std::string programPath(const std::string& name);

/// Runs a program to its end, at most for a minute, within 2 GB of memory.
/// @param arguments     the first is the program's path
/// @param while_running called with the process id a hundred times a second
ProcessResult runProcess(const std::vector<std::string>& arguments,
                         const std::function<void(int)>& while_running = nullptr);

}  // namespace mass_spring
