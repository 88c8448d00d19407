#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "mass_spring_sim/scene_reader.h"

namespace mass_spring {

/// A scene with one object of each type but mesh, two pins, and a timeline.
inline const char* const kSceneText = R"(
frame_id: map
rate: 200.0
objects:
  cable: {type: rope, start: [0.0, 0.0, 1.0], end: [1.0, 0.0, 1.0], segments: 40, mass: 0.2,
          stiffness: 1.0e+4, bend_stiffness: 10.0, damping: 0.1, color: [0.1, 0.2, 0.3, 0.4]}
  sheet: {type: cloth, size: [1.0, 2.0], resolution: [20, 10], position: [0.0, 0.0, 1.0],
          orientation: [0.1, 0.2, 0.3], mass: 0.2, stiffness: 1000.0, shear_stiffness: 500.0,
          bend_stiffness: 100.0, damping: 0.1}
  block: {type: lattice, size: [0.3, 0.4, 0.5], resolution: [4, 3, 2], mass: 1, stiffness: 200}
  net: {type: particles, positions: [[0.0, 0.0, 1.0], [0.1, 0.0, 1.0], [0.2, 0.0, 1.0]],
        velocities: [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]], masses: 0.01,
        springs: [[0, 1], [1, 2]], stiffness: [100.0, 200.0], damping: 0.1, rest_lengths: 0.1}
pins:
  left: {object: sheet, particles: [0, 19]}
  gripper: {object: cable, particles: [40]}
effects: {gravity: {acceleration: [0.0, 0.0, -9.81]}}
timeline:
  - {time: 0.5, force: {object: sheet, particles: [21], forces: [[0.0, 2.0, 0.0]], duration: 0.2}}
  - {time: 1.0, pin: {action: add, name: grab, object: sheet, particles: [199]}}
  - {time: 2.0, pin: {action: move, name: grab, target: [0.5, 0.5, 1.2]}}
  - {time: 3.0, pin: {action: remove, name: grab}}
)";

/// The problems of a tree or text, line by line; empty if it is a scene.
inline std::vector<std::string> problemsOf(const Tree& tree, const std::string& directory = "") {
  try {
    readScene(tree, directory);
  } catch (const SceneError& error) {
    return error.problems();
  }
  return {};
}
inline std::vector<std::string> problemsOf(const std::string& text) {
  try {
    return problemsOf(readYamlText(text, "text"));
  } catch (const SceneError& error) {
    return error.problems();
  }
}

/// Stands for a key that is taken out.
inline const char* const kRemoved = "(removed)";

/// Puts a value, given as YAML, at a path such as timeline[0].force.duration.
inline void put(Tree& tree, const std::string& path, const std::string& yaml) {
  const std::size_t end = path.find_first_of(".[", 1);
  const std::string rest = end == std::string::npos ? "" : path.substr(end);
  std::string step = path.substr(0, end);
  if (step[0] == '[') {
    auto& list = std::get<Tree::List>(tree.value);
    const std::size_t index = std::stoul(step.substr(1));
    if (rest.empty()) {
      list.at(index) = readYamlText(yaml, "value");
    } else {
      put(list.at(index), rest, yaml);
    }
    return;
  }
  if (step[0] == '.') step.erase(0, 1);
  if (!std::holds_alternative<Tree::Map>(tree.value)) tree.value = Tree::Map();
  auto& map = std::get<Tree::Map>(tree.value);
  if (!rest.empty()) {
    put(map[step], rest, yaml);
  } else if (yaml == kRemoved) {
    map.erase(step);
  } else {
    map[step] = readYamlText(yaml, "value");
  }
}

/// The scene above with one value changed.
inline Tree sceneWith(const std::string& path, const std::string& yaml) {
  Tree tree = readYamlText(kSceneText, "scene");
  put(tree, path, yaml);
  return tree;
}

/// A folder that is gone after the test.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "mass_spring_XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no temporary folder");
    path_ = pattern;
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::string path() const { return path_.string(); }
  /// Writes a file, and the folders it lies in; returns its path.
  std::string write(const std::string& name, const std::string& content) const {
    const std::filesystem::path file = path_ / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << content;
    return file.string();
  }
  /// What is in a file; nothing if it is not there.
  std::string read(const std::string& name) const {
    std::ifstream file(path_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

 private:
  std::filesystem::path path_;
};

}  // namespace mass_spring
