#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace mass_spring {

/// what() says what was expected of the name of a file.
class PathError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Where the file of a scene lies: package://PKG/..., an absolute path, or one relative to the
/// directory of the scene ("" = there is none). A package is searched for without ROS, in this
/// order: the folders above the directory and above the current folder, ROS_PACKAGE_PATH, share/ of
/// CMAKE_PREFIX_PATH, /usr/share.
/// @throws PathError
std::filesystem::path findFile(const std::string& file, const std::string& directory);

}  // namespace mass_spring
