#include <gtest/gtest.h>

#include <algorithm>

#include "shapes.h"

namespace mass_spring {
namespace {

TEST(Builders, MassIsSharedEqually) {
  const auto expectShared = [](const Model& model, double mass) {
    // Each addition rounds by 1e-16 of the sum.
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
