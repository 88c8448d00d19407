#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "mass_spring_sim/model.h"

namespace mass_spring {

// Positions are sums and products of a few numbers of size 1: some units in the last place.
constexpr double kRounding = 1e-14;

template <typename Shape>
Model build(const Shape& shape) {
  Model model;
  appendObject({"thing", {1, 0, 0, 1}, shape}, model);
  EXPECT_EQ(model.particleCount(), particleCount({"thing", {1, 0, 0, 1}, shape}));
  return model;
}

inline std::map<SpringKind, std::size_t> countByKind(const Model& model) {
  std::map<SpringKind, std::size_t> counts;
  for (const Spring& spring : model.springs) ++counts[spring.kind];
  return counts;
}

inline std::set<std::pair<std::uint32_t, std::uint32_t>> pairsOf(const Model& model,
                                                                 SpringKind kind) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (const Spring& spring : model.springs) {
    if (spring.kind == kind) pairs.insert(std::minmax(spring.i, spring.j));
  }
  return pairs;
}

/// What holds for any model: what each test would otherwise repeat.
inline void expectSound(const Model& model) {
  ASSERT_EQ(model.start.positions.cols(), model.masses.size());
  ASSERT_EQ(model.start.velocities.cols(), model.masses.size());
  EXPECT_EQ(model.start.step, 0u);
  EXPECT_EQ(model.start.time, 0.0);
  EXPECT_TRUE(std::is_sorted(model.springs.begin(), model.springs.end(),
                             [](const Spring& a, const Spring& b) { return a.kind < b.kind; }));
  std::size_t distinct = 0;
  for (const auto kind : {SpringKind::kStructural, SpringKind::kShear, SpringKind::kBending}) {
    distinct += pairsOf(model, kind).size();
  }
  EXPECT_EQ(distinct, model.springs.size()) << "a spring was made twice";
  for (const Spring& spring : model.springs) {
    ASSERT_NE(spring.i, spring.j);
    ASSERT_LT(std::max(spring.i, spring.j), model.particleCount());
    const double distance =
        (model.start.positions.col(spring.j) - model.start.positions.col(spring.i)).norm();
    EXPECT_NEAR(spring.rest_length, distance, kRounding);
  }
}

inline Rope someRope(int segments) {
  Rope rope;
  rope.start = {0.1, 0.2, 0.3};
  rope.end = {1.1, -0.4, 0.7};
  rope.segments = segments;
  rope.mass = 0.2;
  rope.stiffness = 500.0;
  return rope;
}

inline Cloth someCloth(int columns, int rows) {
  Cloth cloth;
  cloth.size = {1.5, 0.8};
  cloth.resolution = {columns, rows};
  cloth.position = {0.1, 0.2, 0.3};
  cloth.mass = 0.2;
  cloth.stiffness = 1000.0;
  cloth.shear_stiffness = 500.0;
  cloth.bend_stiffness = 100.0;
  cloth.damping = 0.1;
  return cloth;
}

inline Lattice someLattice(int nx, int ny, int nz) {
  Lattice lattice;
  lattice.size = {0.3, 0.4, 0.5};
  lattice.resolution = {nx, ny, nz};
  lattice.mass = 2.0;
  lattice.stiffness = 1000.0;
  lattice.shear_stiffness = 500.0;
  lattice.bend_stiffness = 100.0;
  return lattice;
}

/// A regular tetrahedron of edge sqrt(2), faces outwards.
inline Mesh tetrahedron() {
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 1, 0}, {1, 0, 1}, {0, 1, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
  mesh.mass = 4.0;
  mesh.stiffness = 50.0;
  return mesh;
}

}  // namespace mass_spring
