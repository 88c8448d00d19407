#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "effects/air_drag.h"
#include "effects/contact.h"
#include "effects/gravity.h"
#include "effects/self_collision.h"
#include "effects/springs.h"
#include "effects/strain_limit.h"
#include "effects/wind.h"
#include "mass_spring_sim/model.h"
#include "scheme_choice.h"
#include "solvers/block_pattern.h"

namespace mass_spring {
namespace {

template <typename Property>
bool any(const std::vector<Spring>& springs, Property property) {
  for (const Spring& s : springs) {
    if (s.*property > 0.0) return true;
  }
  return false;
}

/// The last check before the numerics, for scenes that did not come through the reader.
void requirePhysical(const Scene& scene, const Model& model) {
  std::vector<std::string> problems;
  const auto require = [&](bool good, const std::string& path, double value, const char* expected) {
    if (good) return;
    std::ostringstream problem;
    problem << path << ": got " << value << ", expected " << expected;
    problems.push_back(problem.str());
  };
  require(scene.rate > 0.0 && std::isfinite(scene.rate), "rate", scene.rate, "a number > 0 (Hz)");
  require(scene.solver.substeps >= 1, "solver.substeps", scene.solver.substeps, "at least 1");
  if (const auto& drag = scene.effects.air_drag) {
    require(drag->coefficient >= 0.0 && std::isfinite(drag->coefficient),
            "effects.air_drag.coefficient", drag->coefficient, "a number >= 0 (N s/m)");
  }
  if (const auto& contact = scene.effects.contact) {
    const auto requirePositive = [&](double value, const char* field, const char* expected) {
      require(value > 0.0 && std::isfinite(value), std::string("effects.contact.") + field, value,
              expected);
    };
    requirePositive(contact->stiffness, "stiffness", "a number > 0 (N/m)");
    requirePositive(contact->slip_velocity, "slip_velocity", "a number > 0 (m/s)");
    require(contact->thickness >= 0.0 && std::isfinite(contact->thickness),
            "effects.contact.thickness", contact->thickness, "a number >= 0 (m)");
    const double friction = contact->friction.value_or(0.0);
    require(friction >= 0.0 && std::isfinite(friction), "effects.contact.friction", friction,
            "a number >= 0");
  }
  if (const auto& limit = scene.effects.strain_limit) {
    require(limit->max_strain >= 0.0 && std::isfinite(limit->max_strain),
            "effects.strain_limit.max_strain", limit->max_strain, "a number >= 0");
    require(limit->stiffness_ratio > 0.0 && std::isfinite(limit->stiffness_ratio),
            "effects.strain_limit.stiffness_ratio", limit->stiffness_ratio, "a number > 0");
  }
  if (const auto& tearing = scene.effects.tearing) {
    require(tearing->max_strain > 0.0 && std::isfinite(tearing->max_strain),
            "effects.tearing.max_strain", tearing->max_strain, "a number > 0");
  }
  if (const auto& plasticity = scene.effects.plasticity) {
    require(plasticity->yield_strain >= 0.0 && std::isfinite(plasticity->yield_strain),
            "effects.plasticity.yield_strain", plasticity->yield_strain, "a number >= 0");
    require(plasticity->creep_rate > 0.0 && std::isfinite(plasticity->creep_rate),
            "effects.plasticity.creep_rate", plasticity->creep_rate, "a number > 0 (1/s)");
  }
  if (const auto& collision = scene.effects.self_collision) {
    require(collision->thickness > 0.0 && std::isfinite(collision->thickness),
            "effects.self_collision.thickness", collision->thickness, "a number > 0 (m)");
    const double stiffness = collision->stiffness.value_or(1.0);
    require(stiffness > 0.0 && std::isfinite(stiffness), "effects.self_collision.stiffness",
            stiffness, "a number > 0 (N/m)");
  }
  for (Eigen::Index i = 0; i < model.masses.size(); ++i) {
    const double m = model.masses[i];
    require(m > 0.0 && std::isfinite(m), "masses[" + std::to_string(i) + "]", m, "a mass > 0 (kg)");
  }
  for (std::size_t s = 0; s < model.springs.size(); ++s) {
    const Spring& spring = model.springs[s];
    const auto requireNotNegative = [&](double value, const char* field, const char* expected) {
      require(value >= 0.0 && std::isfinite(value), "springs[" + std::to_string(s) + "]." + field,
              value, expected);
    };
    requireNotNegative(spring.stiffness, "stiffness", "a number >= 0 (N/m)");
    requireNotNegative(spring.damping, "damping", "a number >= 0 (N s/m)");
    requireNotNegative(spring.rest_length, "rest_length", "a number >= 0 (m)");
  }
  require(scene.limits.max_speed > 0.0 && scene.limits.max_speed <= kLargestCoordinate,
          "limits.max_speed", scene.limits.max_speed, "a number > 0, at most 1e9 (m/s)");
  require(scene.limits.max_extent > 0.0 && scene.limits.max_extent <= kLargestCoordinate,
          "limits.max_extent", scene.limits.max_extent, "a number > 0, at most 1e9 (m)");
  if (!model.start.positions.allFinite()) {
    problems.push_back("positions: got NaN or infinity, expected finite numbers (m)");
  }
  if (!model.start.velocities.allFinite()) {
    problems.push_back("velocities: got NaN or infinity, expected finite numbers (m/s)");
  }
  if (model.particleCount() == 0) {
    problems.push_back("objects: got no particle, expected at least one");
  }
  if (!problems.empty()) throw SceneError(problems);
}

/// How many threads are worth having. Work is shared in two halves; a model that is too small to
/// gain from that has the caller's thread only.
std::uint32_t usefulThreads(int asked_for, const Model& model) {
  constexpr std::uint32_t kLeastParticles = 1000;
  const std::uint32_t most =
      asked_for > 0 ? static_cast<std::uint32_t>(asked_for) : std::thread::hardware_concurrency();
  return model.particleCount() < kLeastParticles ? 1 : std::clamp(most, 1u, 2u);
}

using Effects = std::vector<std::shared_ptr<Effect>>;

/// The effects that the scene asks for, and nothing for those that it does not. They are constant
/// once they know their places in the pattern.
Effects addEffects(Model& model) {
  const EffectOptions& options = model.options;
  Effects effects;
  if (any(model.springs, &Spring::stiffness) || any(model.springs, &Spring::damping)) {
    effects.push_back(
        std::make_shared<Springs>(model.springs, model.particleCount(), model.springs_yield));
  }
  if (options.gravity) {
    effects.push_back(std::make_shared<Gravity>(options.gravity->acceleration, model.masses));
  }
  if (options.air_drag) {
    effects.push_back(std::make_shared<AirDrag>(options.air_drag->coefficient));
  }
  if (options.wind) effects.push_back(std::make_shared<Wind>(*options.wind, model));
  if (options.contact) {
    effects.push_back(std::make_shared<Contact>(*options.contact, model.shapes, model.masses));
  }
  if (options.strain_limit) {
    effects.push_back(std::make_shared<StrainLimit>(*options.strain_limit, model.springs));
  }
  if (options.self_collision) {
    effects.push_back(std::make_shared<SelfCollision>(*options.self_collision, model));
  }
  if (options.tearing) model.spring_changes.push_back("tearing");
  if (options.plasticity) model.spring_changes.push_back("plasticity");
  model.effects.assign(effects.begin(), effects.end());
  return effects;
}

void addPattern(const Effects& effects, Model& model) {
  if (!info(model.solver.scheme).implicit) return;
  PatternBuilder builder;
  // xpbd has no equations of springs.
  const Effect* without = model.solver.scheme == Scheme::kXpbd ? find<Springs>(model) : nullptr;
  for (const auto& effect : effects) {
    if (effect.get() != without) effect->addPattern(builder);
  }
  model.pattern = std::make_shared<BlockPattern>(model.particleCount(), std::move(builder));
  for (const auto& effect : effects) {
    if (effect.get() != without) effect->findSlots(*model.pattern);
  }
}

using Edge = std::pair<std::uint32_t, std::uint32_t>;

/// Pairs of particles that no spring but bending ones joins any longer.
std::vector<Edge> lostEdges(const std::vector<Spring>& springs, const std::vector<char>& gone) {
  std::vector<Edge> lost, left, parted;
  for (std::size_t s = 0; s < springs.size(); ++s) {
    if (springs[s].kind == SpringKind::kBending) continue;
    (gone[s] ? lost : left).push_back(std::minmax(springs[s].i, springs[s].j));
  }
  std::sort(lost.begin(), lost.end());
  std::sort(left.begin(), left.end());
  std::set_difference(lost.begin(), lost.end(), left.begin(), left.end(),
                      std::back_inserter(parted));
  return parted;
}

}  // namespace

Model buildModel(const Scene& scene, bool springs_yield) {
  Model model;
  for (const Object& object : scene.objects) appendObject(object, model);
  requirePhysical(scene, model);
  for (std::size_t s = 0; s < model.springs.size(); ++s) {
    model.springs[s].number = static_cast<std::uint32_t>(s);
  }
  model.rate = scene.rate;
  model.limits = scene.limits;
  model.options = scene.effects;
  model.springs_yield = springs_yield || scene.effects.plasticity;
  model.threads = usefulThreads(scene.solver.threads, model);
  if (scene.effects.contact) {
    for (const ContactShape& shape : scene.effects.contact->shapes) {
      model.shapes.emplace_back(shape);
      model.start.effects.shapes.emplace_back(model.shapes.back().start());
    }
  }
  const Effects effects = addEffects(model);
  SchemeChoice choice = chooseScheme(scene, model);
  model.solver = choice.options;
  model.scheme_reason = std::move(choice.reason);
  addPattern(effects, model);
  return model;
}

Model withoutSprings(const Model& model, const std::vector<char>& gone) {
  const std::vector<Edge> lost = lostEdges(model.springs, gone);
  const auto losesEdge = [&](const std::array<std::uint32_t, 3>& corners) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Edge edge = std::minmax(corners[k], corners[(k + 1) % 3]);
      if (std::binary_search(lost.begin(), lost.end(), edge)) return true;
    }
    return false;
  };
  Model torn;
  torn.masses = model.masses;
  torn.shapes = model.shapes;
  torn.start = model.start;
  torn.rate = model.rate;
  torn.options = model.options;
  torn.springs_yield = model.springs_yield;
  torn.limits = model.limits;
  torn.solver = model.solver;
  torn.scheme_reason = model.scheme_reason;
  torn.threads = model.threads;
  for (ModelObject object : model.objects) {
    const auto springs = static_cast<std::uint32_t>(torn.springs.size());
    for (std::uint32_t s = 0; s < object.spring_count; ++s) {
      const std::uint32_t spring = object.first_spring + s;
      if (!gone[spring]) torn.springs.push_back(model.springs[spring]);
    }
    object.first_spring = springs;
    object.spring_count = static_cast<std::uint32_t>(torn.springs.size()) - springs;
    const auto triangles = static_cast<std::uint32_t>(torn.triangles.size());
    for (std::uint32_t t = 0; t < object.triangle_count; ++t) {
      const auto& corners = model.triangles[object.first_triangle + t];
      if (!losesEdge(corners)) torn.triangles.push_back(corners);
    }
    object.first_triangle = triangles;
    object.triangle_count = static_cast<std::uint32_t>(torn.triangles.size()) - triangles;
    torn.objects.push_back(std::move(object));
  }
  addPattern(addEffects(torn), torn);
  return torn;
}

}  // namespace mass_spring
