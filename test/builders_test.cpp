#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "mass_spring_sim/model.h"

namespace mass_spring {
namespace {

// Positions are sums and products of a few numbers of size 1: some units in the last place.
constexpr double kRounding = 1e-14;

template <typename Shape>
Model build(const Shape& shape) {
  Model model;
  appendObject({"thing", {1, 0, 0, 1}, shape}, model);
  EXPECT_EQ(model.particleCount(), particleCount({"thing", {1, 0, 0, 1}, shape}));
  return model;
}

std::map<SpringKind, std::size_t> countByKind(const Model& model) {
  std::map<SpringKind, std::size_t> counts;
  for (const Spring& spring : model.springs) ++counts[spring.kind];
  return counts;
}

std::set<std::pair<std::uint32_t, std::uint32_t>> pairsOf(const Model& model, SpringKind kind) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (const Spring& spring : model.springs) {
    if (spring.kind == kind) pairs.insert(std::minmax(spring.i, spring.j));
  }
  return pairs;
}

/// What holds for any model: what each test would otherwise repeat.
void expectSound(const Model& model) {
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

Rope someRope(int segments) {
  Rope rope;
  rope.start = {0.1, 0.2, 0.3};
  rope.end = {1.1, -0.4, 0.7};
  rope.segments = segments;
  rope.mass = 0.2;
  rope.stiffness = 500.0;
  return rope;
}

Cloth someCloth(int columns, int rows) {
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

Lattice someLattice(int nx, int ny, int nz) {
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
Mesh tetrahedron() {
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 1, 0}, {1, 0, 1}, {0, 1, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
  mesh.mass = 4.0;
  mesh.stiffness = 50.0;
  return mesh;
}

TEST(RopeBuilder, CountsFollowTheSegments) {
  for (const int segments : {1, 2, 3, 40}) {
    Rope rope = someRope(segments);
    EXPECT_EQ(build(rope).springs.size(), static_cast<std::size_t>(segments));
    rope.bend_stiffness = 3.0;
    const Model model = build(rope);
    expectSound(model);
    EXPECT_EQ(model.particleCount(), segments + 1u);
    auto counts = countByKind(model);
    EXPECT_EQ(counts[SpringKind::kStructural], static_cast<std::size_t>(segments));
    EXPECT_EQ(counts[SpringKind::kBending], static_cast<std::size_t>(segments - 1));
    EXPECT_TRUE(model.triangles.empty());
    EXPECT_FALSE(model.objects[0].has_surface);
  }
}

TEST(RopeBuilder, EndsAreExact) {
  for (const int segments : {1, 3, 7, 49}) {
    const Rope rope = someRope(segments);
    const Model model = build(rope);
    EXPECT_EQ(model.start.positions.col(0), rope.start);
    EXPECT_EQ(model.start.positions.col(segments), rope.end);
  }
}

// Springs in series: n of stiffness k stretch like one of k / n, whatever n.
TEST(RopeBuilder, AxialRigidityGivesTheSameRopeAtAnyResolution) {
  for (const int segments : {1, 4, 25}) {
    Rope rope = someRope(segments);
    rope.stiffness.reset();
    rope.axial_rigidity = 250.0;
    const Model model = build(rope);
    double compliance = 0.0;
    for (const Spring& spring : model.springs) compliance += 1.0 / spring.stiffness;
    const double length = (rope.end - rope.start).norm();
    // Relative, as the sum of 25 equal terms loses some last places.
    EXPECT_NEAR(compliance * 250.0 / length, 1.0, 1e-14);
  }
}

TEST(RopeBuilder, LengthZeroIsARopeOfRestLengthZero) {
  Rope rope = someRope(3);
  rope.end = rope.start;
  for (const Spring& spring : build(rope).springs) {
    EXPECT_EQ(spring.rest_length, 0.0);
    EXPECT_EQ(spring.stiffness, 500.0);
  }
}

TEST(ClothBuilder, CountsFollowTheResolution) {
  for (const auto& [m, n] : {std::pair{2, 2}, {2, 5}, {3, 2}, {7, 4}, {20, 20}}) {
    const Model model = build(someCloth(m, n));
    expectSound(model);
    auto counts = countByKind(model);
    EXPECT_EQ(model.particleCount(), static_cast<std::uint32_t>(m * n));
    EXPECT_EQ(counts[SpringKind::kStructural], static_cast<std::size_t>((m - 1) * n + m * (n - 1)));
    EXPECT_EQ(counts[SpringKind::kShear], static_cast<std::size_t>(2 * (m - 1) * (n - 1)));
    EXPECT_EQ(counts[SpringKind::kBending], static_cast<std::size_t>((m - 2) * n + m * (n - 2)));
    EXPECT_EQ(model.triangles.size(), static_cast<std::size_t>(2 * (m - 1) * (n - 1)));
    EXPECT_TRUE(model.objects[0].has_surface);
  }
}

TEST(ClothBuilder, ParticlesRunAlongTheRows) {
  const Cloth cloth = someCloth(4, 3);
  const Model model = build(cloth);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      const Eigen::Vector3d expected =
          cloth.position + Eigen::Vector3d(-0.75 + 0.5 * column, -0.4 + 0.4 * row, 0.0);
      EXPECT_LT((model.start.positions.col(row * 4 + column) - expected).norm(), kRounding);
    }
  }
}

TEST(ClothBuilder, EachFamilyHasItsStiffness) {
  const Model model = build(someCloth(5, 4));
  for (const Spring& spring : model.springs) {
    const double expected = spring.kind == SpringKind::kStructural ? 1000.0
                            : spring.kind == SpringKind::kShear    ? 500.0
                                                                   : 100.0;
    EXPECT_EQ(spring.stiffness, expected);
    EXPECT_EQ(spring.damping, 0.1);
  }
}

TEST(ClothBuilder, AbsentStiffnessMakesNoSprings) {
  Cloth cloth = someCloth(5, 4);
  cloth.shear_stiffness.reset();
  cloth.damping.reset();
  auto counts = countByKind(build(cloth));
  EXPECT_EQ(counts[SpringKind::kShear], 0u);
  EXPECT_EQ(counts[SpringKind::kBending], 3u * 4u + 5u * 2u);
  cloth.bend_stiffness.reset();
  const Model model = build(cloth);
  EXPECT_EQ(countByKind(model).size(), 1u);
  for (const Spring& spring : model.springs) EXPECT_EQ(spring.damping, 0.0);
}

TEST(ClothBuilder, TrianglesCoverTheSheetAndFaceUp) {
  Cloth cloth = someCloth(6, 4);
  cloth.orientation = {0.3, -0.8, 2.0};
  const Model model = build(cloth);
  const Eigen::Vector3d up = (Eigen::AngleAxisd(2.0, Eigen::Vector3d::UnitZ()) *
                              Eigen::AngleAxisd(-0.8, Eigen::Vector3d::UnitY()) *
                              Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX())) *
                             Eigen::Vector3d::UnitZ();
  double area = 0.0;
  for (const auto& [a, b, c] : model.triangles) {
    const Eigen::Vector3d pa = model.start.positions.col(a);
    const Eigen::Vector3d normal =
        (model.start.positions.col(b) - pa).cross(model.start.positions.col(c) - pa);
    EXPECT_NEAR(normal.normalized().dot(up), 1.0, 1e-12);  // of differences 1/5 m long
    area += normal.norm() / 2.0;
  }
  EXPECT_NEAR(area, 1.5 * 0.8, 1e-12);
}

// REP 103: roll about x first, then pitch about y, then yaw about z, all axes fixed.
TEST(ClothBuilder, OrientationIsRollPitchYaw) {
  Cloth cloth = someCloth(2, 2);
  cloth.size = {2.0, 2.0};
  cloth.position = {0.0, 0.0, 0.0};
  cloth.orientation = {M_PI / 2, 0.0, M_PI / 2};
  const Model model = build(cloth);
  // (1, 1, 0): roll by 90 degrees takes it to (1, 0, 1), yaw by 90 degrees to (0, 1, 1).
  EXPECT_LT((model.start.positions.col(3) - Eigen::Vector3d(0, 1, 1)).norm(), 1e-15);
  cloth.orientation = {0.0, M_PI / 2, 0.0};
  // Pitch by 90 degrees takes x to -z.
  EXPECT_LT((build(cloth).start.positions.col(3) - Eigen::Vector3d(0, 1, -1)).norm(), 1e-15);
}

TEST(ClothBuilder, RotationMovesParticlesAndNothingElse) {
  const Model flat = build(someCloth(6, 5));
  Cloth cloth = someCloth(6, 5);
  cloth.orientation = {0.4, 1.1, -0.7};
  const Model turned = build(cloth);
  ASSERT_EQ(flat.springs.size(), turned.springs.size());
  for (std::size_t s = 0; s < flat.springs.size(); ++s) {
    EXPECT_EQ(flat.springs[s].rest_length, turned.springs[s].rest_length);
  }
  const Eigen::Vector3d centre = turned.start.positions.rowwise().mean();
  EXPECT_LT((centre - cloth.position).norm(), kRounding);
}

TEST(LatticeBuilder, CountsFollowTheResolution) {
  for (const auto& [x, y, z] : {std::array{2, 2, 2}, {4, 4, 4}, {2, 3, 5}, {5, 2, 2}, {3, 4, 2}}) {
    const Model model = build(someLattice(x, y, z));
    expectSound(model);
    auto counts = countByKind(model);
    const int cx = x - 1, cy = y - 1, cz = z - 1;
    EXPECT_EQ(model.particleCount(), static_cast<std::uint32_t>(x * y * z));
    EXPECT_EQ(counts[SpringKind::kStructural],
              static_cast<std::size_t>(cx * y * z + x * cy * z + x * y * cz));
    // Each face of each cell once, with two diagonals; four through each cell.
    EXPECT_EQ(
        counts[SpringKind::kShear],
        static_cast<std::size_t>(2 * (cx * cy * z + cx * y * cz + x * cy * cz) + 4 * cx * cy * cz));
    EXPECT_EQ(counts[SpringKind::kBending],
              static_cast<std::size_t>((x - 2) * y * z + x * (y - 2) * z + x * y * (z - 2)));
    EXPECT_FALSE(model.objects[0].has_surface);
  }
}

TEST(LatticeBuilder, ParticlesRunAlongXThenYThenZ) {
  const Model model = build(someLattice(4, 3, 2));
  for (int iz = 0; iz < 2; ++iz) {
    for (int iy = 0; iy < 3; ++iy) {
      for (int ix = 0; ix < 4; ++ix) {
        const Eigen::Vector3d expected(-0.15 + 0.1 * ix, -0.2 + 0.2 * iy, -0.25 + 0.5 * iz);
        EXPECT_LT((model.start.positions.col((iz * 3 + iy) * 4 + ix) - expected).norm(), kRounding);
      }
    }
  }
}

// With all stiffnesses equal, each corner of a 2 x 2 x 2 block is joined with the seven others.
TEST(LatticeBuilder, SmallestBlockJoinsEveryPair) {
  const Model model = build(someLattice(2, 2, 2));
  std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (const Spring& spring : model.springs) pairs.insert(std::minmax(spring.i, spring.j));
  EXPECT_EQ(pairs.size(), 8u * 7u / 2u);
  EXPECT_EQ(model.springs.size(), 28u);
}

TEST(MeshBuilder, TwoTrianglesBendAcrossTheirSharedEdge) {
  Mesh mesh = tetrahedron();
  mesh.triangles = {{0, 1, 2}, {2, 1, 3}};
  mesh.damping = 0.2;
  EXPECT_EQ(build(mesh).springs.size(), 5u);
  mesh.bend_stiffness = 7.0;
  const Model model = build(mesh);
  expectSound(model);
  ASSERT_EQ(model.springs.size(), 6u);
  EXPECT_EQ(pairsOf(model, SpringKind::kBending),
            (std::set<std::pair<std::uint32_t, std::uint32_t>>{{0, 3}}));
  EXPECT_EQ(model.springs.back().stiffness, 7.0);
  EXPECT_EQ(model.springs.back().damping, 0.2);
  EXPECT_EQ(model.triangles, mesh.triangles);
}

// All six edges of a tetrahedron are interior; across each lies the opposite edge.
TEST(MeshBuilder, TetrahedronBendsAlongItsEdges) {
  Mesh mesh = tetrahedron();
  mesh.bend_stiffness = 7.0;
  const Model model = build(mesh);
  expectSound(model);
  EXPECT_EQ(pairsOf(model, SpringKind::kStructural).size(), 6u);
  EXPECT_EQ(pairsOf(model, SpringKind::kBending), pairsOf(model, SpringKind::kStructural));
  EXPECT_TRUE(model.objects[0].has_surface);
}

TEST(MeshBuilder, EveryPairOfTrianglesAtAnEdgeBends) {
  Mesh mesh = tetrahedron();
  mesh.vertices.push_back({0, 0, 2});
  mesh.triangles = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}};  // three pages of a book
  mesh.bend_stiffness = 7.0;
  const Model model = build(mesh);
  EXPECT_EQ(pairsOf(model, SpringKind::kStructural).size(), 1u + 2u * 3u);
  EXPECT_EQ(pairsOf(model, SpringKind::kBending),
            (std::set<std::pair<std::uint32_t, std::uint32_t>>{{2, 3}, {2, 4}, {3, 4}}));
}

TEST(MeshBuilder, DegenerateTrianglesMakeNoSpringToItself) {
  Mesh mesh = tetrahedron();
  mesh.triangles = {{0, 1, 2}, {1, 2, 0}, {3, 3, 1}};  // one twice, one with a corner twice
  mesh.bend_stiffness = 7.0;
  const Model model = build(mesh);
  for (const Spring& spring : model.springs) EXPECT_NE(spring.i, spring.j);
  EXPECT_EQ(pairsOf(model, SpringKind::kStructural).size(), 4u);
  EXPECT_EQ(countByKind(model)[SpringKind::kStructural], 4u);
}

TEST(MeshBuilder, VerticesAreScaledTurnedAndMoved) {
  Mesh mesh = tetrahedron();
  mesh.scale = 0.5;
  mesh.orientation = {0.0, 0.0, M_PI / 2};
  mesh.position = {0.0, 0.0, 3.0};
  const Model model = build(mesh);
  // (1, 0, 1) scaled to (0.5, 0, 0.5), turned to (0, 0.5, 0.5), then lifted.
  EXPECT_LT((model.start.positions.col(2) - Eigen::Vector3d(0, 0.5, 3.5)).norm(), kRounding);
  for (const Spring& spring : model.springs) {
    EXPECT_NEAR(spring.rest_length, std::sqrt(0.5), kRounding);
  }
}

TEST(ParticlesBuilder, TakesEverythingAsGiven) {
  Particles net;
  net.positions = {{0, 0, 0}, {1, 0, 0}, {1, 2, 0}};
  net.velocities = {{0, 0, 1}, {0, 2, 0}, {3, 0, 0}};
  net.masses = {0.1, 0.2, 0.3};
  net.springs = {{2, 0}, {0, 1}, {1, 0}};  // twice the same: valid, both are kept
  net.stiffness = {10.0, 20.0, 30.0};
  const Model model = build(net);
  ASSERT_EQ(model.springs.size(), 3u);
  for (int p = 0; p < 3; ++p) {
    EXPECT_EQ(model.start.positions.col(p), net.positions[p]);
    EXPECT_EQ(model.start.velocities.col(p), net.velocities[p]);
    EXPECT_EQ(model.masses[p], net.masses[p]);
  }
  EXPECT_EQ(model.springs[0].i, 2u);
  EXPECT_EQ(model.springs[0].j, 0u);
  EXPECT_EQ(model.springs[0].rest_length, std::sqrt(5.0));
  EXPECT_EQ(model.springs[2].stiffness, 30.0);
  EXPECT_EQ(model.springs[2].damping, 0.0);

  net.rest_lengths = {0.5, 0.0, 2.0};
  net.damping = {1.0, 2.0, 3.0};
  const Model given = build(net);
  for (std::size_t s = 0; s < 3; ++s) {
    EXPECT_EQ(given.springs[s].rest_length, (*net.rest_lengths)[s]);
    EXPECT_EQ(given.springs[s].damping, (*net.damping)[s]);
  }
}

TEST(ParticlesBuilder, OneParticleWithoutSprings) {
  Particles dust;
  dust.positions = {{1, 2, 3}};
  dust.velocities = {{0, 0, 0}};
  dust.masses = {0.1};
  const Model model = build(dust);
  EXPECT_EQ(model.particleCount(), 1u);
  EXPECT_TRUE(model.springs.empty());
}

TEST(Builders, MassIsSharedEqually) {
  const auto expectShared = [](const Model& model, double mass) {
    EXPECT_NEAR(model.masses.sum(), mass, 1e-14 * mass * model.particleCount());
    EXPECT_EQ(model.masses.minCoeff(), model.masses.maxCoeff());
  };
  expectShared(build(someRope(9)), 0.2);
  expectShared(build(someCloth(7, 3)), 0.2);
  expectShared(build(someLattice(3, 4, 5)), 2.0);
  expectShared(build(tetrahedron()), 4.0);
}

TEST(Builders, ObjectsFollowOneAnother) {
  Model model;
  appendObject({"block", {1, 0, 0, 1}, someLattice(2, 2, 2)}, model);
  appendObject({"sheet", {0, 1, 0, 1}, someCloth(3, 2)}, model);
  appendObject({"skin", {0, 0, 1, 1}, tetrahedron()}, model);
  ASSERT_EQ(model.particleCount(), 8u + 6u + 4u);
  ASSERT_EQ(model.objects.size(), 3u);
  std::uint32_t particle = 0, spring = 0, triangle = 0;
  for (const ModelObject& object : model.objects) {
    EXPECT_EQ(object.first_particle, particle);
    EXPECT_EQ(object.first_spring, spring);
    EXPECT_EQ(object.first_triangle, triangle);
    particle += object.particle_count;
    for (std::uint32_t s = 0; s < object.spring_count; ++s, ++spring) {
      const auto [low, high] = std::minmax(model.springs[spring].i, model.springs[spring].j);
      EXPECT_GE(low, object.first_particle);
      EXPECT_LT(high, particle);
    }
    for (std::uint32_t t = 0; t < object.triangle_count; ++t, ++triangle) {
      for (const std::uint32_t corner : model.triangles[triangle]) {
        EXPECT_EQ(&model.objectOf(corner), &object);
      }
    }
  }
  EXPECT_EQ(spring, model.springs.size());
  EXPECT_EQ(triangle, model.triangles.size());
  // The second object looks just as it would alone.
  EXPECT_EQ(model.start.positions.middleCols(8, 6), build(someCloth(3, 2)).start.positions);
}

TEST(Model, FindsObjectsByNameAndByParticle) {
  Model model;
  appendObject({"a", {1, 0, 0, 1}, someRope(2)}, model);
  EXPECT_EQ(model.findObject(""), &model.objects[0]);
  appendObject({"b", {0, 1, 0, 0.5}, someRope(4)}, model);
  EXPECT_EQ(model.findObject(""), nullptr);
  EXPECT_EQ(model.findObject("c"), nullptr);
  EXPECT_EQ(model.findObject("b"), &model.objects[1]);
  EXPECT_EQ(model.findObject("b")->color, Eigen::Vector4d(0, 1, 0, 0.5));
  EXPECT_EQ(model.objectOf(2).name, "a");
  EXPECT_EQ(model.objectOf(3).name, "b");
  EXPECT_EQ(model.objectOf(7).name, "b");
  EXPECT_TRUE(model.effectNames().empty());
}

}  // namespace
}  // namespace mass_spring
