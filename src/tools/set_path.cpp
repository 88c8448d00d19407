#include "tools/set_path.h"

#include <algorithm>
#include <charconv>

#include "mass_spring_sim/scene.h"

namespace mass_spring {
namespace {

Tree& element(Tree::List& list, const std::string& key, const std::string& path) {
  std::size_t index = 0;
  const char* const end = key.data() + key.size();
  const auto [stop, error] = std::from_chars(key.data(), end, index);
  if (error != std::errc() || stop != end || index >= list.size()) {
    throw SceneError({path + ": got \"" + key + "\", expected an index below " +
                      std::to_string(list.size()) + ", the length of the list"});
  }
  return list[index];
}

Tree& child(Tree& tree, const std::string& key, const std::string& path) {
  if (key.empty()) throw SceneError({"\"" + path + "\": got an empty key, expected KEY.KEY..."});
  if (std::holds_alternative<std::monostate>(tree.value)) tree.value = Tree::Map();
  if (auto* map = std::get_if<Tree::Map>(&tree.value)) return (*map)[key];
  if (auto* list = std::get_if<Tree::List>(&tree.value)) return element(*list, key, path);
  throw SceneError({path +
                    ": got a path through a single value, expected a map or a list above \"" + key +
                    "\""});
}

}  // namespace

void setPath(Tree& tree, const std::string& path, const std::string& value) {
  Tree* node = &tree;
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    node = &child(*node, path.substr(begin, end - begin), path);
    begin = end + 1;
  }
  *node = readYamlText(value, path);
}

void setPath(Tree& tree, const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos) {
    throw SceneError({"--set: got \"" + assignment + "\", expected PATH=VALUE"});
  }
  setPath(tree, assignment.substr(0, equals), assignment.substr(equals + 1));
}

}  // namespace mass_spring
