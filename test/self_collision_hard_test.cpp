#include <gtest/gtest.h>

#include <random>

#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/simulation.h"
#include "passages.h"
#include "problems.h"
#include "sanitizers.h"

// Self-collision where it is hard: crumpled from the start, in long steps, with very stiff springs.
namespace mass_spring {
namespace {

Scene sheetInVacuum(double stiffness, double rate, Scheme scheme) {
  Cloth cloth;
  cloth.size = {0.3, 0.3};
  cloth.resolution = {6, 6};
  cloth.mass = 0.05;
  cloth.stiffness = stiffness;
  cloth.shear_stiffness = 0.1 * stiffness;
  cloth.damping = 0.01;
  Scene scene;
  scene.rate = rate;
  scene.solver.scheme = scheme;
  scene.solver.newton_tolerance = 1e-3;
  scene.solver.threads = 1;
  scene.objects = {{"sheet", {}, cloth}};
  scene.effects.self_collision = SelfCollisionOptions{0.02, {}};
  return scene;
}

/// Puts every particle anywhere in a box of this half width [m], at rest.
void scramble(Simulation& simulation, double half) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> place(-half, half);
  PinCommand pin;
  for (std::uint32_t i = 0; i < simulation.model().particleCount(); ++i) {
    pin.action = PinCommand::Action::kAdd;
    pin.name = "p" + std::to_string(i);
    pin.particles = {i};
    pin.here = true;
    ASSERT_TRUE(simulation.apply(pin).accepted());
    pin.action = PinCommand::Action::kMove;
    pin.target.position = {place(random), place(random), place(random)};
    ASSERT_TRUE(simulation.apply(pin).accepted());
  }
  simulation.step();
  simulation.step();  // the first one has moved them
  simulation.clearPins();
}

class CrumpledSheet : public testing::TestWithParam<Scheme> {};
INSTANTIATE_TEST_SUITE_P(Schemes, CrumpledSheet,
                         testing::ValuesIn(underSanitizers()
                                               ? std::vector{Scheme::kLinearImplicitEuler}
                                               : std::vector{Scheme::kLinearImplicitEuler,
                                                             Scheme::kImplicitEuler,
                                                             Scheme::kTrBdf2}),
                         schemeName);

TEST_P(CrumpledSheet, StaysFiniteAndOnlyLosesEnergyInABox) {
  Scene scene = sheetInVacuum(100.0, 100.0, GetParam());
  ContactOptions& box = scene.effects.contact.emplace();
  box.stiffness = 100.0;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d inwards = Eigen::Vector3d::Unit(axis);
    box.shapes.push_back({"a" + std::to_string(axis), Plane{-0.25 * inwards, inwards}});
    box.shapes.push_back({"b" + std::to_string(axis), Plane{0.25 * inwards, -inwards}});
  }
  Simulation simulation(scene);
  scramble(simulation, 0.12);
  const double start = energy(simulation.model(), simulation.state()).total();
  EXPECT_EQ(energy(simulation.model(), simulation.state()).kinetic, 0.0);
  double before = start;
  for (int step = 0; step < 30; ++step) {
    ASSERT_NE(simulation.step().status, StepStatus::kFailed);
    ASSERT_TRUE(simulation.state().positions.allFinite());
    // What one step may seem to gain: see EnergyCheck.
    const double now = energy(simulation.model(), simulation.state()).total();
    EXPECT_LE(now, before + 2e-3 * start);
    EXPECT_LE(now, start * (1.0 + 1e-4));
    before = now;
  }
  EXPECT_LT(before, 0.9 * start);
  EXPECT_LT(simulation.state().positions.cwiseAbs().maxCoeff(), 0.26);
}

// Steps ten times too long for what happens, with springs a million times as stiff as cloth's: what
// passes through is pushed back, or the step says that it was not made as asked for.
TEST_P(CrumpledSheet, LongStepsOfStiffSheetsSayWhatPassed) {
  for (const double stiffness : {100.0, 1e8}) {
    Scene scene = sheetInVacuum(stiffness, 10.0, GetParam());
    scene.effects.gravity = GravityOptions{Eigen::Vector3d(0.0, 0.0, -kGravity)};
    pin(scene, {3, 9, 15, 21, 27, 33});
    Simulation simulation(scene);
    const double start = energy(simulation.model(), simulation.state()).total();
    for (int step = 0; step < 5; ++step) {
      const Vectors from = simulation.state().positions;
      const StepReport report = simulation.step();
      ASSERT_NE(report.status, StepStatus::kFailed);
      const Vectors& to = simulation.state().positions;
      ASSERT_TRUE(to.allFinite());
      if (passages(simulation.model(), from, to) > 0) {
        EXPECT_NE(report.status, StepStatus::kConverged);
      }
      EXPECT_LE(energy(simulation.model(), simulation.state()).total(), start + 1e-3);
    }
  }
}

}  // namespace
}  // namespace mass_spring
