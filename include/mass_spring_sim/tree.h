#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <variant>
#include <vector>

namespace mass_spring {

/// A scene before it is interpreted: nested maps, lists and scalars. YAML files and the parameter
/// server are both turned into a Tree, and one reader reads it, so that both give the same scene.
struct Tree {
  using List = std::vector<Tree>;
  using Map = std::map<std::string, Tree>;  // bytewise order: the order of objects, pins and shapes

  std::variant<std::monostate, bool, std::int64_t, double, std::string, List, Map> value;
};

/// Reads a YAML file with the scalar rules of YAML 1.1, as rosparam does.
/// @throws SceneError  file missing, too large, not YAML, nested too deeply, keys given twice
Tree readYamlFile(const std::string& path);

/// The same for text; `name` stands for the file in messages.
Tree readYamlText(const std::string& text, const std::string& name);

}  // namespace mass_spring
