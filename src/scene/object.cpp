#include <initializer_list>

#include "object_parts.h"

namespace mass_spring {
namespace {

std::uint32_t product(std::initializer_list<int> factors) {
  std::uint32_t result = 1;
  for (const int factor : factors) result *= static_cast<std::uint32_t>(factor);
  return result;
}

std::uint32_t count(const Rope& rope) { return static_cast<std::uint32_t>(rope.segments) + 1; }
std::uint32_t count(const Cloth& cloth) {
  return product({cloth.resolution[0], cloth.resolution[1]});
}
std::uint32_t count(const Lattice& lattice) {
  return product({lattice.resolution[0], lattice.resolution[1], lattice.resolution[2]});
}
std::uint32_t count(const Mesh& mesh) { return static_cast<std::uint32_t>(mesh.vertices.size()); }
std::uint32_t count(const Particles& particles) {
  return static_cast<std::uint32_t>(particles.positions.size());
}

using Resolution = std::array<std::uint32_t, 3>;

Resolution resolution(const Rope& rope) { return {count(rope), 1, 1}; }
Resolution resolution(const Cloth& cloth) {
  return {static_cast<std::uint32_t>(cloth.resolution[0]),
          static_cast<std::uint32_t>(cloth.resolution[1]), 1};
}
Resolution resolution(const Lattice& lattice) {
  return {static_cast<std::uint32_t>(lattice.resolution[0]),
          static_cast<std::uint32_t>(lattice.resolution[1]),
          static_cast<std::uint32_t>(lattice.resolution[2])};
}
Resolution resolution(const Mesh&) { return {0, 0, 0}; }
Resolution resolution(const Particles&) { return {0, 0, 0}; }

/// Appends columns (or rows of a vector) at the end.
template <typename Matrix>
void append(const Matrix& tail, Matrix& matrix) {
  if constexpr (Matrix::ColsAtCompileTime == 1) {
    matrix.conservativeResize(matrix.size() + tail.size());
    matrix.tail(tail.size()) = tail;
  } else {
    matrix.conservativeResize(Eigen::NoChange, matrix.cols() + tail.cols());
    matrix.rightCols(tail.cols()) = tail;
  }
}

}  // namespace

std::uint32_t particleCount(const Object& object) {
  return std::visit([](const auto& shape) { return count(shape); }, object.shape);
}

void appendObject(const Object& object, Model& model) {
  const ObjectParts parts =
      std::visit([](const auto& shape) { return buildParts(shape); }, object.shape);

  const std::uint32_t first = model.particleCount();
  model.objects.push_back(
      {object.name, object.color, first, static_cast<std::uint32_t>(parts.masses.size()),
       static_cast<std::uint32_t>(model.springs.size()),
       static_cast<std::uint32_t>(parts.springs.size()),
       static_cast<std::uint32_t>(model.triangles.size()),
       static_cast<std::uint32_t>(parts.triangles.size()), !parts.triangles.empty(),
       std::visit([](const auto& shape) { return resolution(shape); }, object.shape)});
  append(parts.masses, model.masses);
  append(parts.positions, model.start.positions);
  append(parts.velocities, model.start.velocities);
  for (Spring spring : parts.springs) {
    spring.i += first;
    spring.j += first;
    model.springs.push_back(spring);
  }
  for (const auto& [a, b, c] : parts.triangles) {
    model.triangles.push_back({a + first, b + first, c + first});
  }
}

}  // namespace mass_spring
