#include "load_simulation.h"

#include <exception>

#include "mass_spring_sim/scene_reader.h"
#include "xmlrpc_tree.h"

namespace mass_spring {

namespace {

// A parameter of the node, which is none of the scene's.
constexpr char kExternalClock[] = "external_clock";

}  // namespace

std::shared_ptr<Simulation> loadSimulation(const ros::NodeHandle& nh,
                                           std::vector<std::string>& problems) {
  XmlRpc::XmlRpcValue parameters;
  const bool any = nh.getParam("", parameters);
  try {
    Tree tree = any ? toTree(parameters) : Tree{Tree::Map{}};
    if (auto* keys = std::get_if<Tree::Map>(&tree.value)) keys->erase(kExternalClock);
    return std::make_shared<Simulation>(readScene(tree, ""));
  } catch (const SceneError& error) {
    problems = error.problems();
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
