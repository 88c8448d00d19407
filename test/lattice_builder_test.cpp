#include <gtest/gtest.h>

#include <array>
#include <set>
#include <utility>

#include "shapes.h"

namespace mass_spring {
namespace {

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

// The elasticities that config/scenes/lattice.yaml derives: C11 = (k + 10/3 s) / a, C12 = C44 =
// 7/3 s / a. The energy of n^3 cells is a cubic in n, whose third difference is six times that of a
// cell inside, the lower powers being the surface's.
TEST(LatticeBuilder, ElasticitiesFollowTheStiffnesses) {
  const double k = 314.0, s = 86.0, a = 0.05;                // N/m, N/m, m
  const auto density = [&](const Eigen::Matrix3d& strain) {  // 2 E / (cell volume)
    std::array<double, 4> energies{};
    for (int n = 1; n <= 4; ++n) {
      Lattice lattice = someLattice(n + 1, n + 1, n + 1);
      lattice.size.setConstant(n * a);
      lattice.stiffness = k;
      lattice.shear_stiffness = s;
      lattice.bend_stiffness.reset();
      const Model model = build(lattice);
      for (const Spring& spring : model.springs) {
        const Eigen::Vector3d d =
            model.start.positions.col(spring.j) - model.start.positions.col(spring.i);
        const double stretch = d.dot(strain * d) / d.norm();  // for small strains
        energies[n - 1] += spring.stiffness * stretch * stretch / 2.0;
      }
    }
    const double third = energies[3] - 3.0 * energies[2] + 3.0 * energies[1] - energies[0];
    return 2.0 * third / 6.0 / (a * a * a);
  };
  Eigen::Matrix3d xx = Eigen::Matrix3d::Zero(), yy = xx, xy = xx;
  xx(0, 0) = yy(1, 1) = 1.0;
  xy(0, 1) = xy(1, 0) = 0.5;
  const double c11 = (k + 10.0 / 3.0 * s) / a, c12 = 7.0 / 3.0 * s / a;
  // The differences cancel two digits of sums of thousands of terms.
  EXPECT_NEAR(density(xx) / c11, 1.0, 1e-11);
  EXPECT_NEAR((density(xx + yy) - density(xx) - density(yy)) / 2.0 / c12, 1.0, 1e-11);
  EXPECT_NEAR(density(xy) / c12, 1.0, 1e-11);
}

}  // namespace
}  // namespace mass_spring
