#include "mass_spring_sim/model.h"

#include <algorithm>

#include "effects/effect.h"

namespace mass_spring {

Model::Model() = default;
Model::~Model() = default;
Model::Model(Model&&) noexcept = default;
Model& Model::operator=(Model&&) noexcept = default;

const ModelObject* Model::findObject(const std::string& name) const {
  if (name.empty()) return objects.size() == 1 ? &objects.front() : nullptr;
  const auto found = std::find_if(objects.begin(), objects.end(),
                                  [&](const ModelObject& object) { return object.name == name; });
  return found == objects.end() ? nullptr : &*found;
}

const ModelObject& Model::objectOf(std::uint32_t particle) const {
  const auto next = std::upper_bound(
      objects.begin(), objects.end(), particle,
      [](std::uint32_t p, const ModelObject& object) { return p < object.first_particle; });
  return *(next - 1);
}

std::optional<std::size_t> Model::findShape(const std::string& name) const {
  for (std::size_t s = 0; s < shapes.size(); ++s) {
    if (shapes[s].name() == name) return s;
  }
  return std::nullopt;
}

std::vector<std::string> Model::effectNames() const {
  std::vector<std::string> names;
  for (const auto& effect : effects) {
    for (const std::string& name : effect->traits().names) names.push_back(name);
  }
  names.insert(names.end(), spring_changes.begin(), spring_changes.end());
  return names;
}

}  // namespace mass_spring
