#include "load_simulation.h"

#include <exception>

#include "mass_spring_sim/scene_reader.h"
#include "xmlrpc_tree.h"

namespace mass_spring {

std::shared_ptr<Simulation> loadSimulation(const ros::NodeHandle& nh,
                                           std::vector<std::string>& problems) {
  XmlRpc::XmlRpcValue parameters;
  const bool any = nh.getParam("", parameters);
  try {
    const Tree tree = any ? toTree(parameters) : Tree{Tree::Map{}};
    return std::make_shared<Simulation>(readScene(tree, ""));
  } catch (const SceneError& error) {
    problems = error.problems();
  } catch (const std::exception& error) {
    problems = {std::string("The scene cannot be built: ") + error.what()};
  }
  return nullptr;
}

}  // namespace mass_spring
