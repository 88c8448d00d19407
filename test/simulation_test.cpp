#include "mass_spring_sim/simulation.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "problems.h"
#include "sanitizers.h"

namespace mass_spring {
namespace {

TEST(SetState, PutsAllParticlesSomewhereElseAndForgetsWhatWas) {
  for (Scheme scheme : allSchemes()) {
    Scene scene = hangingCloth(6, scheme);
    scene.rate = 1000.0;  // or explicit schemes would explode, beyond what may be set
    Simulation one(scene), other(scene), third(scene);
    for (int n = 0; n < 10; ++n) one.step();
    for (int n = 0; n < 4; ++n) other.step();
    const State state = one.state();
    for (Simulation* simulation : {&one, &other, &third}) {
      const std::uint64_t step = simulation->state().step;
      ASSERT_TRUE(simulation->setState(state.positions, state.velocities).accepted());
      EXPECT_EQ(simulation->state().positions, state.positions);
      EXPECT_EQ(simulation->state().velocities, state.velocities);
      EXPECT_EQ(simulation->state().step, step);
    }
    for (int n = 0; n < 5; ++n) {
      for (Simulation* simulation : {&one, &other, &third}) simulation->step();
      EXPECT_EQ(other.state().positions, one.state().positions) << name(scheme);
      EXPECT_EQ(third.state().velocities, one.state().velocities) << name(scheme);
    }
  }
}

TEST(SetState, RefusesWhatIsNoState) {
  Simulation simulation(freeParticles());
  const Vectors start = simulation.state().positions;
  const Vectors good = Vectors::Ones(3, 3), few = Vectors::Ones(3, 2);
  Vectors bad = good;
  bad(1, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(simulation.setState(few, good).refusal, Refusal::kBadLength);
  EXPECT_EQ(simulation.setState(good, few).refusal, Refusal::kBadLength);
  EXPECT_EQ(simulation.setState(bad, good).refusal, Refusal::kNotFinite);
  const CommandResult result = simulation.setState(good, bad);
  EXPECT_EQ(result.message, "velocities[7]: got nan, expected a finite number (m/s)");
  EXPECT_EQ(simulation.state().positions, start);
}

TEST(Simulation, CountsTimeInWholeSteps) {
  Simulation simulation(freeParticles());
  for (int n = 0; n < 1000; ++n) simulation.step();
  EXPECT_EQ(simulation.state().time, 10.0);  // not a sum of 1000 roundings
  EXPECT_EQ(simulation.state().step, 1000u);
}

TEST(Simulation, ResetRestoresTheStartBitForBit) {
  Simulation simulation(hangingCloth(8, Scheme::kImplicitEuler));
  const State start = simulation.state();
  std::vector<Vectors> first;
  for (int n = 0; n < 20; ++n) {
    simulation.step();
    first.push_back(simulation.state().positions);
  }
  ForceCommand lift;
  lift.forces = {Eigen::Vector3d(0, 0, 1)};
  lift.duration = -1.0;
  ASSERT_TRUE(simulation.apply(lift).accepted());
  simulation.clearPins();
  simulation.step();
  simulation.reset();
  EXPECT_EQ(simulation.state().step, 0u);
  EXPECT_EQ(simulation.totals().steps, 0u);
  EXPECT_TRUE(sameBytes(simulation.state().positions, start.positions));
  EXPECT_TRUE(sameBytes(simulation.state().velocities, start.velocities));
  for (const Vectors& positions : first) {
    simulation.step();
    ASSERT_TRUE(sameBytes(simulation.state().positions, positions));
  }
}

TEST(Simulation, SameSceneSameBytes) {
  for (const SchemeInfo& scheme : schemes()) {
    Scene scene = hangingCloth(20, scheme.scheme);
    scene.rate = 400.0;
    Simulation a(scene), b(scene);
    for (int n = 0; n < (underSanitizers() ? 5 : 30); ++n) {
      a.step();
      b.step();
    }
    EXPECT_TRUE(sameBytes(a.state().positions, b.state().positions)) << scheme.name;
    EXPECT_GT((a.state().positions - a.model().start.positions).norm(), 1e-3) << scheme.name;
  }
}

// Two sub-steps of h / 2 are two steps of h / 2.
TEST(Simulation, SubstepsAreSmallerSteps) {
  Scene fine = hangingCloth(8, Scheme::kImplicitEuler);
  Scene coarse = fine;
  fine.rate = 120.0;
  coarse.solver.substeps = 2;
  Simulation a(fine), b(coarse);
  for (int n = 0; n < 20; ++n) {
    a.step();
    a.step();
    b.step();
  }
  // 1e-12: 1/120 and 1/60/2 may differ in the last bit.
  EXPECT_LT((a.state().positions - b.state().positions).norm(), 1e-12);
}

TEST(Simulation, RefusesUnphysicalScenesByName) {
  Scene scene = freeParticles();
  auto& net = std::get<Particles>(scene.objects[0].shape);
  net.masses[1] = -1.0;
  net.springs = {{0, 2}};
  net.stiffness = {std::numeric_limits<double>::quiet_NaN()};
  net.rest_lengths = {{-0.5}};
  scene.rate = 0.0;
  try {
    Simulation simulation(scene);
    FAIL() << "accepted";
  } catch (const SceneError& error) {
    for (const char* part :
         {"rate", "masses[1]", "springs[0].stiffness", "springs[0].rest_length"}) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  }
}

TEST(Effects, AreThereOnlyIfAskedFor) {
  Scene scene = freeParticles();
  EXPECT_TRUE(buildModel(scene).effectNames().empty());
  auto& net = std::get<Particles>(scene.objects[0].shape);
  net.springs = {{0, 1}};
  net.stiffness = {10.0};
  EXPECT_EQ(buildModel(scene).effectNames(), std::vector<std::string>{"springs"});
  net.damping = {{0.0}};
  EXPECT_EQ(buildModel(scene).effectNames(), std::vector<std::string>{"springs"});
  net.damping = {{0.1}};
  scene.effects.gravity = GravityOptions{Eigen::Vector3d(0, 0, -1)};
  EXPECT_EQ(buildModel(scene).effectNames(),
            (std::vector<std::string>{"springs", "spring_damping", "gravity"}));
}

class ZeroCoefficients : public testing::TestWithParam<Scheme> {
 protected:
  /// m, between where particles end with the effect and without it, at most
  static double difference(const Scene& with, const Scene& without) {
    Simulation a(with), b(without);
    for (int step = 0; step < 20; ++step) a.step(), b.step();
    EXPECT_GT((b.state().positions - b.model().start.positions).norm(), 1e-4);
    return (a.state().positions - b.state().positions).cwiseAbs().maxCoeff();
  }
  Scene cloth() const {
    Scene scene = hangingCloth(5, GetParam());
    scene.rate = 1000.0;
    return scene;
  }
};
INSTANTIATE_TEST_SUITE_P(Schemes, ZeroCoefficients, testing::ValuesIn(allSchemes()), schemeName);

TEST_P(ZeroCoefficients, OfGravityChangeNoBit) {
  const Scene without = Oscillator().scene(GetParam(), 1000.0);
  Scene with = without;
  with.effects.gravity = GravityOptions{Eigen::Vector3d::Zero()};
  EXPECT_EQ(difference(with, without), 0.0);
}

TEST_P(ZeroCoefficients, OfDampingChangeNoBit) {
  Scene with = cloth(), without = cloth();
  std::get<Cloth>(with.objects[0].shape).damping = 0.0;
  std::get<Cloth>(without.objects[0].shape).damping.reset();
  EXPECT_EQ(difference(with, without), 0.0);
}

TEST_P(ZeroCoefficients, OfFrictionChangeNoBit) {
  Scene without = cloth();
  ContactOptions& contact = without.effects.contact.emplace();
  contact.stiffness = 10.0;
  // Tilted, and touched from the start.
  contact.shapes = {{"slope", Plane{{0.0, 0.0, 0.0}, {0.6, 0.0, 0.8}}}};
  Scene with = without;
  with.effects.contact->friction = 0.0;
  EXPECT_EQ(difference(with, without), 0.0);
}

// Their places in the matrix change the order in which it is eliminated, and so the rounding: of
// positions of 1 m some 1e-16 a step, which forces carry on.
TEST_P(ZeroCoefficients, OfShearAndBendingChangeRoundingOnly) {
  Scene without = cloth();
  Cloth& sheet = std::get<Cloth>(without.objects[0].shape);
  sheet.shear_stiffness.reset();
  sheet.bend_stiffness.reset();
  sheet.damping.reset();  // which all springs have
  Scene with = without;
  std::get<Cloth>(with.objects[0].shape).shear_stiffness = 0.0;
  std::get<Cloth>(with.objects[0].shape).bend_stiffness = 0.0;
  EXPECT_GT(buildModel(with).springs.size(), buildModel(without).springs.size());
  EXPECT_LT(difference(with, without), 1e-12);
}

}  // namespace
}  // namespace mass_spring
