#include "scene/polygon.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace mass_spring {
namespace {

using Points = std::vector<Eigen::Vector3d>;
using Triangles = std::vector<std::array<std::uint32_t, 3>>;

Triangles cut(const Points& points) {
  std::vector<std::uint32_t> corners(points.size());
  std::iota(corners.begin(), corners.end(), 0u);
  return cutPolygon(points, corners);
}

/// The sum of the areas as vectors: triangles that were turned over would take some away.
Eigen::Vector3d area(const Points& points, const Triangles& triangles) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& [a, b, c] : triangles) {
    sum += 0.5 * (points[b] - points[a]).cross(points[c] - points[a]);
  }
  return sum;
}

double absoluteArea(const Points& points, const Triangles& triangles) {
  double sum = 0.0;
  for (const auto& triangle : triangles) sum += area(points, {triangle}).norm();
  return sum;
}

TEST(Polygon, CutsQuadrilateralsAlongTheShorterDiagonal) {
  EXPECT_EQ(cut({{0, 0, 0}, {2, 1, 0}, {0, 2, 0}, {-2, 1, 0}}), (Triangles{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(cut({{2, 1, 0}, {0, 2, 0}, {-2, 1, 0}, {0, 0, 0}}), (Triangles{{0, 1, 3}, {1, 2, 3}}));
  // All squares of a grid that lies askew are cut alike, though rounding makes some diagonals
  // longer.
  const double c = std::cos(0.3), s = std::sin(0.3);
  const auto corner = [&](int i, int j) {
    return Eigen::Vector3d(0.1 * (c * i - s * j), 0.1 * (s * i + c * j), 0.0);
  };
  for (int i = 0; i < 20; ++i) {
    for (int j = 0; j < 20; ++j) {
      EXPECT_EQ(cut({corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)}),
                (Triangles{{0, 1, 3}, {1, 2, 3}}))
          << i << ' ' << j;
    }
  }
}

TEST(Polygon, CutsConcaveQuadrilateralsAtTheirConcaveCorner) {
  // An arrow head whose shorter diagonal, 1 to 3, lies outside of it.
  const Points arrow = {{0, 0, 0}, {1, -1, 0}, {5, 0, 0}, {1, 1, 0}};
  Points concave = arrow;
  concave[0].x() = 2.0;
  EXPECT_EQ(absoluteArea(arrow, cut(arrow)), 5.0);      // 5 times 2, halved: small integers, exact
  EXPECT_EQ(absoluteArea(concave, cut(concave)), 3.0);  // 3 times 2, halved
}

TEST(Polygon, CoversThePolygonOnceInAnyOrientation) {
  // A comb with two gaps and a corner in the middle of an edge, along each axis and turned over.
  const std::vector<Eigen::Vector2d> comb = {{0, 0}, {2, 0}, {5, 0}, {5, 3}, {4, 3}, {4, 1}, {3, 1},
                                             {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}};
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool reversed : {false, true}) {
      Points points;
      for (const Eigen::Vector2d& p : comb) {
        Eigen::Vector3d point;
        point[axis] = 1.0;
        point[(axis + 1) % 3] = p.x();
        point[(axis + 2) % 3] = p.y();
        points.push_back(point);
      }
      if (reversed) std::reverse(points.begin(), points.end());
      const Triangles triangles = cut(points);
      ASSERT_EQ(triangles.size(), comb.size() - 2);
      // 5 by 3 without two gaps of 1 by 2; sums of halves of small integers are exact.
      EXPECT_EQ(area(points, triangles)[axis], reversed ? -11.0 : 11.0);
      EXPECT_EQ(absoluteArea(points, triangles), 11.0);
    }
  }
}

TEST(Polygon, GivesUpOnPolygonsThatCrossThemselvesOrHaveNoArea) {
  EXPECT_LT(cut({{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}}).size(), 2u);
  EXPECT_LT(cut({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}).size(), 2u);
  EXPECT_LT(cut({{0, 0, 0}, {4, 0, 0}, {1, 3, 0}, {2, -2, 0}, {3, 3, 0}}).size(), 3u);
}

}  // namespace
}  // namespace mass_spring
