#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <utility>

#include "shapes.h"

namespace mass_spring {
namespace {

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

}  // namespace
}  // namespace mass_spring
