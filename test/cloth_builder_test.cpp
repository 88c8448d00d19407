#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "shapes.h"

namespace mass_spring {
namespace {

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
  EXPECT_NEAR(area, 1.5 * 0.8, 1e-12);  // rounding of a sum of the triangles
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
  const Eigen::Vector3d center = turned.start.positions.rowwise().mean();
  EXPECT_LT((center - cloth.position).norm(), kRounding);
}

}  // namespace
}  // namespace mass_spring
