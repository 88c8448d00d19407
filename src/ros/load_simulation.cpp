#include "load_simulation.h"

#include <exception>
#include <filesystem>
#include <stdexcept>
#include <utility>
#include <variant>

#include "mass_spring_sim/scene_reader.h"
#include "scene/file_path.h"
#include "xmlrpc_tree.h"

namespace mass_spring {

namespace {

// Parameters of the node, which are none of the scene's.
constexpr char kExternalClock[] = "external_clock";
constexpr char kSceneFile[] = "scene_file";

class ParameterError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The folder of the scene's file; "" = the node was not told.
/// @throws ParameterError if the parameter is no path
std::string sceneFolder(const ros::NodeHandle& nh) {
  if (!nh.hasParam(kSceneFile)) return "";
  std::string file;
  if (!nh.getParam(kSceneFile, file) || !std::filesystem::path(file).is_absolute()) {
    throw ParameterError(std::string(kSceneFile) + ": got " +
                         (file.empty() ? "something else" : '\'' + file + '\'') +
                         ", expected the absolute path of the scene's file");
  }
  return std::filesystem::path(file).parent_path();
}

/// Whoever gets the scene from the node, as `replay` does, knows no folder.
void nameFilesInFull(const std::string& folder, Scene& scene) {
  const auto complete = [&folder](std::string& file) {
    if (!file.empty() && file.compare(0, 10, "package://") != 0) file = findFile(file, folder);
  };
  complete(scene.solver.calibration_file);
  for (Object& object : scene.objects) {
    if (auto* mesh = std::get_if<Mesh>(&object.shape)) complete(mesh->file);
  }
}

}  // namespace

std::shared_ptr<Simulation> loadSimulation(const ros::NodeHandle& nh,
                                           std::vector<std::string>& problems) {
  XmlRpc::XmlRpcValue parameters;
  const bool any = nh.getParam("", parameters);
  try {
    Tree tree = any ? toTree(parameters) : Tree{Tree::Map{}};
    if (auto* keys = std::get_if<Tree::Map>(&tree.value)) {
      keys->erase(kExternalClock);
      keys->erase(kSceneFile);
    }
    const std::string folder = sceneFolder(nh);
    Scene scene = readScene(tree, folder);
    nameFilesInFull(folder, scene);
    return std::make_shared<Simulation>(std::move(scene));
  } catch (const SceneError& error) {
    problems = error.problems();
  } catch (const ParameterError& error) {
    problems = {error.what()};
  } catch (const std::exception& error) {
    problems = {std::string("The scene cannot be built: ") + error.what()};
  }
  return nullptr;
}

bool loadExternalClock(const ros::NodeHandle& nh, std::vector<std::string>& problems) {
  bool follow = false;
  if (nh.hasParam(kExternalClock) && !nh.getParam(kExternalClock, follow)) {
    problems = {std::string(kExternalClock) + ": got something else, expected true or false"};
  } else if (follow && !ros::Time::isSimTime()) {
    problems = {std::string(kExternalClock) +
                ": got true, to follow a /clock, but /use_sim_time is false; expected both"};
  }
  return follow;
}

}  // namespace mass_spring
