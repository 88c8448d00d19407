#include "effects/plasticity.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/simulation.h"
#include "problems.h"
#include "scene_text.h"

// Rest lengths that yield.
namespace mass_spring {
namespace {

const Spring kSpring = {0, 1, 0.5, 10.0, 0.0, SpringKind::kStructural};

Vectors apart(double length) {
  Vectors x = Vectors::Zero(3, 2);
  x(1, 1) = length;
  return x;
}

// With l held, L - M decays by e^(-c t), in any steps.
TEST(Plasticity, ASpringRelaxesAsTheClosedFormSays) {
  const PlasticityOptions options{0.1, 3.0};
  for (const double length : {0.8, 0.3}) {
    const double limit = length > 0.5 ? length / 1.1 : length / 0.9;
    for (const int steps : {1, 7, 1000}) {
      std::vector<double> rest;
      for (int n = 0; n < steps; ++n) {
        creep(options, 0.4 / steps, {kSpring}, 1, apart(length), rest);
      }
      // Rounding, in a thousand steps.
      EXPECT_NEAR(rest.at(0), limit + (0.5 - limit) * std::exp(-3.0 * 0.4), 1e-13) << steps;
    }
    std::vector<double> rest;
    creep(options, 1e9, {kSpring}, 1, apart(length), rest);
    EXPECT_DOUBLE_EQ(rest.at(0), limit);
  }
}

TEST(Plasticity, BelowYieldingNothingChanges) {
  std::vector<double> rest;
  for (const double length : {0.46, 0.5, 0.54}) {
    creep({0.1, 3.0}, 1.0, {kSpring}, 1, apart(length), rest);
    EXPECT_TRUE(rest.empty());
  }
  // No compression is beyond 1, and a spring without rest length has no strain.
  creep({1.5, 3.0}, 1.0, {kSpring}, 1, apart(0.0), rest);
  Spring linear = kSpring;
  linear.rest_length = 0.0;
  creep({0.1, 3.0}, 1.0, {linear}, 1, apart(1.0), rest);
  EXPECT_TRUE(rest.empty());
}

TEST(Plasticity, RestLengthsStayAboveZero) {
  std::vector<double> rest;
  for (int n = 0; n < 3; ++n) creep({0.1, 1e6}, 1.0, {kSpring}, 1, apart(0.0), rest);
  EXPECT_GT(rest.at(0), 0.0);
  // And come back from there.
  creep({0.1, 1e6}, 1.0, {kSpring}, 1, apart(0.5), rest);
  EXPECT_NEAR(rest.at(0), 0.5 / 1.1, 1e-15);
}

class Yielding : public testing::TestWithParam<Scheme> {
 protected:
  static Scene cloth(double yield_strain) {
    Scene scene = hangingCloth(6, GetParam());
    scene.rate = info(GetParam()).implicit              ? 60.0
                 : GetParam() == Scheme::kExplicitEuler ? 8000.0
                                                        : 1000.0;
    scene.effects.plasticity = PlasticityOptions{yield_strain, 5.0};
    return scene;
  }
  static void run(Simulation& simulation, double seconds) {
    const double end = simulation.state().time + seconds;
    while (simulation.state().time < end) {
      ASSERT_NE(simulation.step().status, StepStatus::kFailed);
    }
  }
};
INSTANTIATE_TEST_SUITE_P(Schemes, Yielding, testing::ValuesIn(allSchemes()), schemeName);

TEST_P(Yielding, NoBitChangesBelowTheYieldStrain) {
  Scene plastic = cloth(10.0), elastic = plastic;
  elastic.effects.plasticity.reset();
  Simulation a(elastic), b(plastic);
  run(a, 0.3);
  run(b, 0.3);
  EXPECT_TRUE(sameBytes(a.state().positions, b.state().positions));
  EXPECT_TRUE(sameBytes(a.state().velocities, b.state().velocities));
  EXPECT_EQ(a.matrixNonzeros(), b.matrixNonzeros());
}

TEST_P(Yielding, ResetMendsAndContinueFromCarriesOn) {
  Simulation simulation(cloth(1e-4));
  Scene elastic = cloth(1e-4);
  elastic.effects.plasticity.reset();
  Simulation never(elastic);
  run(simulation, 0.5);
  run(never, 0.5);
  const State half = simulation.state();
  EXPECT_GT((half.positions - never.state().positions).norm(), 1e-5);

  // A continued run knows the rest lengths, by which the energy is known, whatever goes on.
  Simulation after(cloth(1e-4));
  ASSERT_TRUE(after.continueFrom(simulation));
  const auto elasticEnergy = [](const Simulation& s) { return s.energy().elastic; };
  EXPECT_EQ(elasticEnergy(after), elasticEnergy(simulation));
  Simulation frozen(elastic);
  ASSERT_TRUE(frozen.continueFrom(simulation));
  EXPECT_EQ(elasticEnergy(frozen), elasticEnergy(simulation));
  State as_built = half;
  as_built.effects = never.state().effects;
  EXPECT_NE(energy(never.model(), as_built).elastic, elasticEnergy(simulation));
  if (GetParam() != Scheme::kBdf2) {  // which forgets the state before
    Simulation on(cloth(1e-4));
    ASSERT_TRUE(on.continueFrom(after));
    run(simulation, 0.2);
    run(on, 0.2);
    // Without control of the steps, all that a step depends on has been taken over.
    EXPECT_LT((on.state().positions - simulation.state().positions).norm(), 1e-7);
  }
  simulation.reset();
  EXPECT_EQ(elasticEnergy(simulation), elasticEnergy(Simulation(elastic)));
  run(simulation, 0.5);
  EXPECT_TRUE(sameBytes(simulation.state().positions, half.positions));
  frozen.reset();
  run(frozen, 0.5);
  EXPECT_TRUE(sameBytes(frozen.state().positions, never.state().positions));
}

// A spring whose ends are held is shorter in energy after each step, and never gains.
TEST(Plasticity, YieldingOnlyTakesEnergy) {
  Particles net = chain(2, 0.5, {1, 0, 0}, 0.1, 20.0);
  net.damping.emplace(2, 1.0);
  Scene scene = netScene(net, Scheme::kTrBdf2, 50.0);
  scene.pins = {{"a", "net", {0}}, {"b", "net", {2}}};
  scene.effects.plasticity = PlasticityOptions{0.05, 2.0};
  Simulation simulation(scene);
  PinCommand move;
  move.action = PinCommand::Action::kMove;
  move.name = "b";
  move.target.position = {1.4, 0, 0};
  ASSERT_TRUE(simulation.apply(move).accepted());
  simulation.step();
  double before = energy(simulation.model(), simulation.state()).total();
  for (int n = 0; n < 500; ++n) {
    simulation.step();
    const double now = energy(simulation.model(), simulation.state()).total();
    EXPECT_LE(now, before * (1.0 + 1e-6)) << n;  // Newton's tolerance
    before = now;
  }
  // What yielding leaves: each spring of 0.7 m at its yield strain. The spring that was stretched
  // more at first has yielded more, and the other one less.
  const double rest = 0.7 / 1.05;
  EXPECT_NEAR(simulation.pinWrenches().at("b").force.x(), -20.0 * (0.7 - rest), 1e-3);
}

// Three particles, bent by a right angle between pins and then let go: the bending spring has
// become as short as it is at its yield strain, which at rest is the angle that stays.
TEST(Plasticity, ABentCableKeepsItsBend) {
  const double a = 0.1, yield = 0.02, bent = 2.0 * a * std::sqrt(0.5);
  Scene scene;
  scene.rate = 100.0;
  scene.solver.scheme = Scheme::kTrBdf2;
  Rope rope;
  rope.start = {0, 0, 0};
  rope.end = {2.0 * a, 0, 0};
  rope.segments = 2;
  rope.mass = 0.03;
  rope.stiffness = 500.0;
  rope.bend_stiffness = 50.0;
  rope.damping = 0.5;
  scene.objects = {{"cable", {1, 1, 1, 1}, rope}};
  scene.pins = {{"left", "cable", {0}}, {"middle", "cable", {1}}, {"right", "cable", {2}}};
  scene.effects.plasticity = PlasticityOptions{yield, 10.0};
  scene.effects.air_drag = AirDragOptions{0.05};
  Simulation simulation(scene);
  const auto moveTo = [&](const char* pin, const Eigen::Vector3d& target) {
    PinCommand move;
    move.action = PinCommand::Action::kMove;
    move.name = pin;
    move.target.position = target;
    ASSERT_TRUE(simulation.apply(move).accepted());
  };
  for (int n = 1; n <= 300; ++n) {
    const double angle = 0.25 * M_PI * std::min(1.0, n / 100.0);
    moveTo("left", {a - a * std::cos(angle), -a * std::sin(angle), 0});
    moveTo("right", {a + a * std::cos(angle), -a * std::sin(angle), 0});
    simulation.step();
  }
  simulation.clearPins();
  for (int n = 0; n < 3000; ++n) simulation.step();
  const Vectors& x = simulation.state().positions;
  // Two seconds at 10 1/s and more leave e^-20 of what was to yield; so do the vibrations. Free,
  // all three springs have their rest lengths.
  EXPECT_NEAR((x.col(2) - x.col(0)).norm(), bent / (1.0 - yield), 1e-5);
  EXPECT_NEAR((x.col(1) - x.col(0)).norm(), a, 1e-5);
  const double half = std::asin(bent / (1.0 - yield) / (2.0 * a));
  const Eigen::Vector3d left = x.col(0) - x.col(1), right = x.col(2) - x.col(1);
  EXPECT_NEAR(std::acos(left.dot(right) / (left.norm() * right.norm())), 2.0 * half, 1e-3);
}

// What tears goes with the lengths it has; strains to tear at are those of the start.
TEST(Plasticity, GoesTogetherWithTearing) {
  Scene scene = netScene(chain(4, 0.5, {1, 0, 0}, 0.1, 20.0), Scheme::kTrBdf2, 50.0);
  scene.pins = {{"a", "net", {0}}, {"b", "net", {2, 3}}, {"c", "net", {4}}};
  scene.effects.plasticity = PlasticityOptions{0.05, 2.0};
  scene.effects.tearing = TearingOptions{0.5};
  Simulation simulation(scene);
  for (int n = 0; n <= 400; ++n) {
    PinCommand move;
    move.action = PinCommand::Action::kMove;
    move.name = "c";
    move.target.position = {2.0 + 0.001 * n, 0, 0};
    ASSERT_TRUE(simulation.apply(move).accepted());
    move.name = "a";
    move.target.position = {-std::min(0.3, 0.001 * n), 0, 0};
    ASSERT_TRUE(simulation.apply(move).accepted());
    EXPECT_EQ(simulation.step().broken_springs, n == 251 ? 1u : 0u) << n;
  }
  // Two springs that were stretched from 1 m to 1.3 m, at their yield strain but for e^-4.
  EXPECT_NEAR(simulation.pinWrenches().at("a").force.x(), 20.0 * (0.65 - 0.65 / 1.05), 0.1);
}

TEST(PlasticityReader, ReadsWritesAndRefuses) {
  const Scene scene =
      readScene(sceneWith("effects.plasticity", "{yield_strain: 0.01, creep_rate: 5}"), "");
  ASSERT_TRUE(scene.effects.plasticity);
  EXPECT_EQ(scene.effects.plasticity->yield_strain, 0.01);
  EXPECT_EQ(scene.effects.plasticity->creep_rate, 5.0);
  const std::string yaml = toYaml(scene);
  EXPECT_EQ(toYaml(readScene(readYamlText(yaml, "scene"), "")), yaml);
  EXPECT_NE(yaml.find("creep_rate"), std::string::npos);
  EXPECT_EQ(problemsOf(sceneWith("effects.plasticity", "{yield_strain: -1}")),
            (std::vector<std::string>{
                "effects.plasticity.yield_strain: got -1, expected a number >= 0",
                "effects.plasticity.creep_rate: got nothing, expected a number > 0 (1/s)"}));
}

}  // namespace
}  // namespace mass_spring
