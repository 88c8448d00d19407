#include "scene/object_reader.h"

#include <algorithm>
#include <cmath>

#include "scene/file_path.h"
#include "scene/mesh_file.h"

namespace mass_spring {
namespace {

// About 200 MB of state and springs per million particles; beyond this it is a slip of the pen, and
// should end in a message instead of all memory.
constexpr std::uint32_t kMostParticles = 2'000'000;
const std::string kTooMany = "at most " + std::to_string(kMostParticles) + " particles";

const char* const kStiffnessUnit = "N/m";
const char* const kDampingUnit = "N s/m";

/// Position and orientation of an object in the scene's frame.
template <typename Shape>
void readPlacement(MapReader& keys, Shape& shape) {
  readPosition(keys.optional("position"), shape.position);
  keys.optional("orientation").read(shape.orientation, anyNumber("rad"));
}

template <int n>
void readResolution(const Place& place, std::array<int, n>& resolution) {
  const std::string expected = "a list of " + std::to_string(n) + " integers >= 2";
  const Tree::List* list = place.list(expected);
  if (list == nullptr) return;
  if (list->size() != n) return place.refuse(expected);
  std::uint64_t particles = 1;  // (2e6)^3 still fits
  for (int i = 0; i < n; ++i) {
    if (!place.element(i).read(resolution[i], 2, kMostParticles)) return;
    particles *= static_cast<std::uint64_t>(resolution[i]);
  }
  if (particles > kMostParticles) place.report(std::to_string(particles) + " particles", kTooMany);
}

void readRope(MapReader& keys, Rope& rope) {
  const bool has_start = readPosition(keys.required("start"), rope.start);
  const bool has_end = readPosition(keys.required("end"), rope.end);
  keys.required("segments").read(rope.segments, 1, kMostParticles - 1);
  keys.required("mass").read(rope.mass, positive("kg"));
  const Place stiffness = keys.optional("stiffness");
  const Place rigidity = keys.optional("axial_rigidity");
  stiffness.read(rope.stiffness, atLeastZero(kStiffnessUnit));
  const bool has_rigidity = rigidity.read(rope.axial_rigidity, positive("N"));
  if (stiffness.present() && rigidity.present()) {
    rigidity.report("a stiffness as well", "either stiffness or axial_rigidity");
  } else if (!stiffness.present() && !rigidity.present()) {
    stiffness.refuse(atLeastZero(kStiffnessUnit).one() + ", or axial_rigidity instead");
  } else if (has_rigidity && has_start && has_end &&
             !std::isfinite(*rope.axial_rigidity * rope.segments /
                            (rope.end - rope.start).norm())) {
    rigidity.report("a rope without length", "different start and end, or stiffness instead");
  }
  keys.optional("bend_stiffness").read(rope.bend_stiffness, atLeastZero(kStiffnessUnit));
  keys.optional("damping").read(rope.damping, atLeastZero(kDampingUnit));
}

/// What cloth and lattice share: the axes that they have are in their type.
template <typename Grid, int n>
void readGrid(MapReader& keys, Grid& grid) {
  readSize(keys.required("size"), grid.size);
  readResolution<n>(keys.required("resolution"), grid.resolution);
  readPlacement(keys, grid);
  keys.required("mass").read(grid.mass, positive("kg"));
  keys.required("stiffness").read(grid.stiffness, atLeastZero(kStiffnessUnit));
  keys.optional("shear_stiffness").read(grid.shear_stiffness, atLeastZero(kStiffnessUnit));
  keys.optional("bend_stiffness").read(grid.bend_stiffness, atLeastZero(kStiffnessUnit));
  keys.optional("damping").read(grid.damping, atLeastZero(kDampingUnit));
}

void readMesh(MapReader& keys, const std::string& directory, Mesh& mesh) {
  const Place file = keys.required("file");
  if (file.read(mesh.file, "a path to an OBJ file")) {
    try {
      MeshFile content = readMeshFile(findFile(mesh.file, directory), kMostParticles);
      mesh.vertices = std::move(content.vertices);
      mesh.triangles = std::move(content.triangles);
    } catch (const std::runtime_error& error) {  // MeshError, PathError
      file.refuse(error.what());
    }
  }
  const Place scale = keys.optional("scale");
  scale.read(mesh.scale, positive("m per unit of the file"));
  double farthest = 0.0;
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    farthest = std::max(farthest, vertex.cwiseAbs().maxCoeff());
  }
  if (scale.present()) {
    isModerate(scale, mesh.scale * farthest, "m from the origin of the file");
  } else {
    isModerate(file, farthest, "m from the origin of the file");
  }
  readPlacement(keys, mesh);
  keys.required("mass").read(mesh.mass, positive("kg"));
  keys.required("stiffness").read(mesh.stiffness, atLeastZero(kStiffnessUnit));
  keys.optional("bend_stiffness").read(mesh.bend_stiffness, atLeastZero(kStiffnessUnit));
  keys.optional("damping").read(mesh.damping, atLeastZero(kDampingUnit));
}

/// A list of points or velocities.
bool readVectors(const Place& place, const std::string& unit,
                 std::vector<Eigen::Vector3d>& vectors) {
  const Tree::List* list = place.list("a list of lists of 3 numbers (" + unit + ")");
  if (list == nullptr) return false;
  vectors.resize(list->size());
  bool good = true;
  for (std::size_t i = 0; i < list->size(); ++i) {
    const Place vector = place.element(i);
    good = vector.read(vectors[i], anyNumber(unit)) &&
           isModerate(vector, vectors[i].cwiseAbs().maxCoeff(), unit) && good;
  }
  return good;
}

void readSprings(const Place& place, int particle_count,
                 std::vector<std::array<std::uint32_t, 2>>& springs) {
  const Tree::List* list = place.list("a list of pairs of particle indices");
  if (list == nullptr) return;
  springs.resize(list->size());
  for (std::size_t i = 0; i < list->size(); ++i) {
    const Place spring = place.element(i);
    const std::string expected = "a pair of different particle indices";
    const Tree::List* ends = spring.list(expected);
    if (ends == nullptr) continue;
    if (ends->size() != 2) {
      spring.refuse(expected);
      continue;
    }
    int a = 0, b = 0;
    const bool has_a = spring.element(0).read(a, 0, particle_count - 1);
    const bool has_b = spring.element(1).read(b, 0, particle_count - 1);
    if (!has_a || !has_b) continue;
    if (a == b)
      spring.report("a spring from particle " + std::to_string(a) + " to itself", expected);
    springs[i] = {static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b)};
  }
}

void readParticleObject(MapReader& keys, Particles& particles) {
  const Place positions = keys.required("positions");
  const Place velocities = keys.optional("velocities");
  const Place springs = keys.optional("springs");
  readVectors(positions, "m", particles.positions);
  const std::size_t count = particles.positions.size();
  if (count > kMostParticles) positions.refuse(kTooMany);
  // Without positions nothing is known about what belongs to them.
  const bool has_positions = count > 0;
  if (!has_positions && positions.present()) positions.refuse("at least one position");

  particles.velocities.assign(count, Eigen::Vector3d::Zero());
  if (velocities.present() && readVectors(velocities, "m/s", particles.velocities) &&
      has_positions && particles.velocities.size() != count) {
    velocities.refuse("a list of " + std::to_string(count) + ", one for each particle");
  }
  if (has_positions) readSprings(springs, static_cast<int>(count), particles.springs);
  const std::size_t spring_count = particles.springs.size();

  const Place masses = keys.required("masses");
  // Where there are no springs, there need not be a stiffness.
  const Place stiffness =
      spring_count > 0 ? keys.required("stiffness") : keys.optional("stiffness");
  const Place damping = keys.optional("damping");
  const Place rest_lengths = keys.optional("rest_lengths");
  if (!has_positions) return;
  masses.readOneOrEach(particles.masses, count, positive("kg"));
  stiffness.readOneOrEach(particles.stiffness, spring_count, atLeastZero(kStiffnessUnit));
  std::vector<double> values;
  if (damping.readOneOrEach(values, spring_count, atLeastZero(kDampingUnit))) {
    particles.damping = values;
  }
  if (rest_lengths.readOneOrEach(values, spring_count, atLeastZero("m"))) {
    particles.rest_lengths = values;
  }
}

void readShape(std::size_t type, MapReader& keys, const std::string& directory, Object& object) {
  switch (type) {
    case 0:
      return readRope(keys, object.shape.emplace<Rope>());
    case 1:
      return readGrid<Cloth, 2>(keys, object.shape.emplace<Cloth>());
    case 2:
      return readGrid<Lattice, 3>(keys, object.shape.emplace<Lattice>());
    case 3:
      return readMesh(keys, directory, object.shape.emplace<Mesh>());
    default:
      return readParticleObject(keys, object.shape.emplace<Particles>());
  }
}

}  // namespace

std::vector<Object> readObjects(const Place& place, const std::string& directory,
                                ParticleCounts& counts) {
  static const std::vector<std::string> kTypes = {"rope", "cloth", "lattice", "mesh", "particles"};
  std::vector<Object> objects;
  const Tree::Map* map = place.map("a map of at least one object");
  if (map == nullptr) return objects;
  if (map->empty()) place.refuse("a map of at least one object");
  std::uint64_t total = 0;
  for (const auto& [name, tree] : *map) {
    const std::size_t problems_before = place.problems().count();
    const Place entry = place.child(name, true);
    if (!isName(name)) entry.report("the name " + quote(name), kNameRule);
    Object object;
    object.name = name;
    counts[name] = std::nullopt;
    MapReader keys(entry, "a map with type and the keys of that type");
    std::size_t type = 0;
    if (!keys.required("type").read(type, kTypes)) continue;
    const Place color = keys.optional("color");
    color.read(object.color, {"red green blue alpha", 0.0, 1.0});
    readShape(type, keys, directory, object);
    keys.refuseUnknown();
    if (place.problems().count() > problems_before) continue;
    counts[name] = particleCount(object);
    total += *counts[name];
    objects.push_back(std::move(object));
  }
  if (total > kMostParticles) place.report(std::to_string(total) + " particles", kTooMany);
  return objects;
}

}  // namespace mass_spring
