#include <gtest/gtest.h>

#include <cmath>

#include "shapes.h"

namespace mass_spring {
namespace {

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

}  // namespace
}  // namespace mass_spring
