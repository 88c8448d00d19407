#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mass_spring_sim/scene.h"
#include "mass_spring_sim/shape.h"
#include "mass_spring_sim/state.h"

namespace mass_spring {

class BlockPattern;
class Effect;

enum class SpringKind : std::uint8_t { kStructural = 0, kShear = 1, kBending = 2 };

struct Spring {
  std::uint32_t i, j;  ///< global particle numbers, i != j
  double rest_length;  ///< m, >= 0
  double stiffness;    ///< N/m, >= 0
  double damping;      ///< N s/m along the spring, >= 0; 0 if the scene gives none
  SpringKind kind;
  /// Counted through the springs of the whole scene, also those that have broken: what the state
  /// remembers of springs has this order.
  std::uint32_t number = 0;
};

/// The ranges that one object of the scene takes in a model.
struct ModelObject {
  std::string name;
  Eigen::Vector4d color;
  std::uint32_t first_particle, particle_count;
  std::uint32_t first_spring, spring_count;
  std::uint32_t first_triangle, triangle_count;
  bool has_surface;  ///< cloth and mesh
  /// Particles along x, y and z of a rope, cloth or lattice, numbered with x fastest; zeros for
  /// others.
  std::array<std::uint32_t, 3> resolution;
};

/// Built from a scene, and then constant: any number of simulations, on any threads, may share one.
/// Particles are numbered through all objects.
struct Model {
  Model();
  ~Model();
  Model(Model&&) noexcept;
  Model& operator=(Model&&) noexcept;

  std::vector<ModelObject> objects;
  Eigen::VectorXd masses;                               ///< kg, > 0
  std::vector<Spring> springs;                          ///< object by object
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< global particle numbers
  std::vector<Shape> shapes;                            ///< of contact, in the order of their names
  State start;
  double rate = 0.0;                                   ///< Hz, of steps
  EffectOptions options;                               ///< of the scene
  std::vector<std::shared_ptr<const Effect>> effects;  ///< the active ones and no others
  std::shared_ptr<const BlockPattern> pattern;  ///< of the step matrix; only for implicit schemes
  Limits limits;                                ///< of the scene
  SolverOptions solver;        ///< of the scene, with auto decided: a scheme and its sub-steps
  std::string scheme_reason;   ///< what auto chose and why; empty if it had nothing to choose
  std::uint32_t threads = 1;   ///< as many as are worth having for one simulation
  bool springs_yield = false;  ///< the state may hold rest lengths other than those as built
  /// The active effects that change springs between steps: tearing, plasticity.
  std::vector<std::string> spring_changes;

  std::uint32_t particleCount() const { return static_cast<std::uint32_t>(masses.size()); }
  /// nullptr if no object has that name; "" finds the only object of a scene with one object.
  const ModelObject* findObject(const std::string& name) const;
  /// The object that holds a global particle number.
  const ModelObject& objectOf(std::uint32_t particle) const;
  /// The index of the shape of contact with that name.
  std::optional<std::size_t> findShape(const std::string& name) const;
  std::vector<std::string> effectNames() const;
};

/// Builds particles and springs object by object, then the effects of the scene.
/// @param scene          validated by the reader
/// @param springs_yield  room for rest lengths that change, also without plasticity
Model buildModel(const Scene& scene, bool springs_yield = false);

/// The model without some of its springs, and without the triangles that have one of these springs
/// as an edge. Particles, shapes and solver stay the same.
/// @param model  whole or torn already
/// @param gone   per spring of that model: is it removed?
Model withoutSprings(const Model& model, const std::vector<char>& gone);

/// The particles, springs and triangles of one object, appended to the model.
void appendObject(const Object& object, Model& model);

}  // namespace mass_spring
