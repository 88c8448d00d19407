#pragma once

#include <string>

#include "mass_spring_sim/tree.h"

namespace mass_spring {

/// Overrides one value of a scene before it is read, so that the strict reader judges the result.
/// @param path   keys joined by dots, from the root; below a list, the index of an element that
///               exists. Maps that are missing are made.
/// @param value  YAML
/// @throws SceneError  path malformed or leading through a scalar; value no YAML
void setPath(Tree& tree, const std::string& path, const std::string& value);

/// setPath with both in one text, as on a command line: PATH=VALUE.
void setPath(Tree& tree, const std::string& assignment);

}  // namespace mass_spring
