#include <gtest/gtest.h>

#include <cmath>

#include "mass_spring_sim/scene_reader.h"
#include "mass_spring_sim/simulation.h"
#include "problems.h"
#include "scene_text.h"

// What becomes of steps and commands beyond limits.max_speed and limits.max_extent.
namespace mass_spring {
namespace {

/// Steps until a step fails. Fails the test if none does within so many.
StepReport stepUntilFailure(Simulation& simulation, int steps) {
  for (int n = 0; n < steps; ++n) {
    const StepReport report = simulation.step();
    if (report.status == StepStatus::kFailed) return report;
  }
  ADD_FAILURE() << "no step failed";
  return {};
}

/// m, how far a particle is from where it started, at most.
double extent(const Simulation& simulation) {
  return (simulation.state().positions - simulation.model().start.positions)
      .colwise()
      .norm()
      .maxCoeff();
}

Scene scene20(Scheme scheme, double rate) {
  Scene scene = hangingCloth(20, scheme);
  scene.rate = rate;
  return scene;
}

/// A rope of 21 particles with a stiffness of 1e5 N/m per spring, level at the start.
Scene stiffRope(Scheme scheme, double rate) {
  Scene scene = netScene(chain(20, 0.05, {1, 0, 0}, 0.2, 1e5), scheme, rate);
  scene.effects.gravity = GravityOptions{Eigen::Vector3d(0, 0, -kGravity)};
  pin(scene, {0});
  return scene;
}

// An explosion grows over several steps and stays finite for a while. The state that it leaves is
// of before, and of the step that the message names.
TEST(Limits, AnExplosionLeavesTheStateBeforeIt) {
  const auto check = [](const Scene& scene) {
    SCOPED_TRACE(name(scene.solver.scheme) + (" at " + std::to_string(scene.rate)) + " Hz");
    Simulation simulation(scene), undisturbed(scene);
    const double start = energy(simulation.model(), simulation.state()).total();
    const StepReport report = stepUntilFailure(simulation, 2000);
    const State& state = simulation.state();
    EXPECT_NE(report.message.find("object "), std::string::npos) << report.message;
    EXPECT_NE(report.message.find(", particle "), std::string::npos) << report.message;
    EXPECT_NE(report.message.find("limits.max_"), std::string::npos) << report.message;
    const std::string kept = "; the state is that of step " + std::to_string(state.step);
    EXPECT_NE(report.message.find(kept), std::string::npos) << report.message;
    EXPECT_EQ(state.time, static_cast<double>(state.step) / scene.rate);
    // All of it is 1 m in size. It has moved for less than 0.1 s, and by no more than it fell.
    EXPECT_LT(extent(simulation), 0.1);
    EXPECT_LT(maxStretch(simulation.model(), state), 2.0);
    EXPECT_LT(energy(simulation.model(), state).kinetic, 0.1);
    EXPECT_LT(energy(simulation.model(), state).total(), start + 0.1);
    // It is one that the run has been through, to the bit.
    while (undisturbed.state().step < state.step) undisturbed.step();
    EXPECT_TRUE(sameBytes(state.positions, undisturbed.state().positions));
    EXPECT_TRUE(sameBytes(state.velocities, undisturbed.state().velocities));
    // It can be gone on from, and explodes in the same way.
    const std::uint64_t step = state.step;
    const StepReport again = stepUntilFailure(simulation, 2000);
    EXPECT_NE(again.message.find("limits.max_"), std::string::npos);
    EXPECT_EQ(simulation.state().step, step);
  };
  for (const double rate : {60.0, 100.0, 500.0}) check(scene20(Scheme::kRk4, rate));
  for (const double rate : {60.0, 200.0, 500.0}) check(scene20(Scheme::kSymplecticEuler, rate));
  for (const double rate : {60.0, 500.0}) check(scene20(Scheme::kExplicitEuler, rate));
  for (const double rate : {100.0, 1000.0}) {
    check(stiffRope(Scheme::kExplicitEuler, rate));
    check(stiffRope(Scheme::kSymplecticEuler, rate));
    check(stiffRope(Scheme::kRk4, rate));
  }
}

// The steps on the way say that they are not to be trusted.
TEST(Limits, AnExplosionIsDegradedBeforeItFails) {
  Simulation simulation(scene20(Scheme::kSymplecticEuler, 500.0));
  bool degraded = false;
  for (StepReport report; report.status != StepStatus::kFailed;) {
    ASSERT_LT(simulation.totals().steps, 100u);
    report = simulation.step();
    if (degraded) {
      EXPECT_NE(report.status, StepStatus::kConverged);
    }
    if (report.status != StepStatus::kDegraded) continue;
    degraded = true;
    EXPECT_NE(report.message.find("gained energy"), std::string::npos) << report.message;
  }
  EXPECT_TRUE(degraded);
}

// Cloth at 1000 Hz with rk4: its largest steps keep it from the limits, at hundreds of km/s.
TEST(Limits, AnExplosionThatStaysBelowThemIsDegraded) {
  Simulation simulation(scene20(Scheme::kRk4, 1000.0));
  StepReport report;
  for (int n = 0; n < 200; ++n) report = simulation.step();
  EXPECT_EQ(report.status, StepStatus::kDegraded);
  EXPECT_NE(report.message.find("rk4 gained energy"), std::string::npos) << report.message;
}

// An explosion late in a run does not throw the run away. A comparison follows at least each 250
// evaluations of the forces: of a scheme with one of them per step, each 250 steps.
TEST(Limits, TheStateLeftIsARecentOne) {
  Scene scene = Oscillator().scene(Scheme::kSymplecticEuler, 100.0);
  scene.limits.max_extent = 100.0;
  Simulation simulation(scene);
  for (int n = 0; n < 3000; ++n) ASSERT_EQ(simulation.step().status, StepStatus::kConverged);
  ForceCommand push;
  push.particles = {1};
  push.forces = {Eigen::Vector3d(1e6, 0, 0)};
  push.duration = -1.0;
  ASSERT_TRUE(simulation.apply(push).accepted());
  stepUntilFailure(simulation, 3000);
  EXPECT_GE(simulation.state().step, 3000u - 250u);
}

// Reloaded with a scheme that is stable at any step, the run goes on from the state that is left.
TEST(Limits, AnotherSchemeGoesOnFromTheStateLeft) {
  Simulation exploded(scene20(Scheme::kRk4, 100.0));
  stepUntilFailure(exploded, 100);
  Simulation simulation(scene20(Scheme::kTrBdf2, 100.0));
  ASSERT_TRUE(simulation.continueFrom(exploded));
  EXPECT_TRUE(sameBytes(simulation.state().positions, exploded.state().positions));
  const std::uint64_t first = simulation.state().step;
  for (int n = 0; n < 100; ++n) ASSERT_EQ(simulation.step().status, StepStatus::kConverged);
  EXPECT_EQ(simulation.state().step, first + 100);
  EXPECT_LT(extent(simulation), 2.0);  // 1 m of cloth hangs at most 1.4 m off, and stretches little
}

// Springs that broke and rest lengths that changed in the explosion are as they were; commands stay
// given, and none of the timeline comes a second time.
TEST(Limits, BrokenSpringsGoBackAndCommandsDoNot) {
  Scene scene = scene20(Scheme::kSymplecticEuler, 500.0);
  scene.effects.tearing = TearingOptions{0.5};
  scene.effects.plasticity = PlasticityOptions{0.2, 1.0};
  PinCommand grab;
  grab.name = "grab";
  grab.particles = {210};
  grab.here = true;
  ForceCommand push;
  push.particles = {5};
  push.forces = {Eigen::Vector3d(0, 0, 1e-6)};
  push.duration = -1.0;
  scene.timeline = {{0.0, push}, {0.01, grab}};
  Simulation simulation(scene);
  const std::size_t springs = simulation.model().springs.size();
  std::vector<std::uint64_t> applied;
  simulation.observeTimeline([&](const Command&, const CommandResult& result) {
    EXPECT_TRUE(result.accepted()) << result.message;
    applied.push_back(simulation.state().step);
  });
  stepUntilFailure(simulation, 1000);
  EXPECT_GT(simulation.totals().broken_springs, 0u);
  EXPECT_LT(simulation.state().step, 5u);
  EXPECT_EQ(simulation.model().springs.size(), springs);
  EXPECT_EQ(applied, (std::vector<std::uint64_t>{0, 5}));
  EXPECT_EQ(simulation.pins().all().count("grab"), 1u);
  EXPECT_EQ(simulation.activeForces(), 1u);
  stepUntilFailure(simulation, 1000);
  EXPECT_EQ(applied.size(), 2u);
  Simulation other(scene);
  ASSERT_TRUE(other.continueFrom(simulation));
  EXPECT_EQ(other.model().springs.size(), springs);
}

// Without an explosion: all schemes, and whatever was the last step.
TEST(Limits, ParticlesThatFallTooFarFail) {
  for (const SchemeInfo& scheme : schemes()) {
    Scene scene = freeParticles(scheme.scheme);
    scene.effects.gravity = GravityOptions{Eigen::Vector3d(0, 0, -kGravity)};
    scene.limits.max_extent = 0.5;
    Simulation simulation(scene);
    const StepReport report = stepUntilFailure(simulation, 100);
    EXPECT_NE(report.message.find("object net, particle 0 is 0.5"), std::string::npos)
        << report.message;
    EXPECT_NE(report.message.find("m from where it started (limits.max_extent: 0.5 m) after " +
                                  std::string(scheme.name)),
              std::string::npos)
        << report.message;
    EXPECT_LE(extent(simulation), 0.5);
    // 0.32 s of fall; a sub-step more or less for schemes of first order.
    if (info(scheme.scheme).implicit) {
      EXPECT_NEAR(static_cast<double>(simulation.state().step), 31.0, 1.0) << scheme.name;
    }
    simulation.reset();
    EXPECT_EQ(simulation.step().status, StepStatus::kConverged);
  }
}

TEST(Limits, ParticlesThatAreTooFastFail) {
  for (const SchemeInfo& scheme : schemes()) {
    Scene scene = freeParticles(scheme.scheme);
    scene.limits.max_speed = 1.0;
    Simulation simulation(scene);
    ForceCommand push;
    push.particles = {2};
    push.forces = {Eigen::Vector3d(0, 1e5, 0)};  // 2000 m/s more in each step
    ASSERT_TRUE(simulation.apply(push).accepted());
    const StepReport report = simulation.step();
    EXPECT_EQ(report.status, StepStatus::kFailed) << scheme.name;
    EXPECT_NE(report.message.find("object net, particle 2 moves at 2000 m/s (at most 1000 times "
                                  "limits.max_speed: 1000 m/s)"),
              std::string::npos)
        << report.message;
    EXPECT_EQ(simulation.state().step, 0u);
  }
}

// A limit that is as small as the scene itself: sums over all particles say nothing then.
TEST(Limits, AreThoseOfEachParticle) {
  Scene scene = scene20(Scheme::kTrBdf2, 100.0);
  scene.limits.max_extent = 1.6;  // a hanging sheet of 1 m gets no farther than its diagonal
  Simulation simulation(scene);
  for (int n = 0; n < 100; ++n) ASSERT_EQ(simulation.step().status, StepStatus::kConverged);
  EXPECT_GT(extent(simulation), 1.0);
}

void expectLimit(const CommandResult& result, const std::string& words, const std::string& limit) {
  EXPECT_EQ(result.refusal, Refusal::kLimit) << words << ": " << result.message;
  EXPECT_NE(result.message.find(words), std::string::npos) << result.message;
  EXPECT_NE(result.message.find(limit), std::string::npos) << result.message;
}

PinCommand moveTo(const Eigen::Vector3d& target) {
  PinCommand move;
  move.action = PinCommand::Action::kMove;
  move.name = "hold";
  move.target.position = target;
  return move;
}

// Three particles at x = 0, 1 and 2 m, in steps of 0.01 s: 1000 m/s are 10 m in a step.
TEST(Limits, PinsAreLedNoFasterAndNoFarther) {
  Scene scene = freeParticles();
  scene.limits.max_extent = 25.0;
  pin(scene, {0, 2});  // their middle is at x = 1 m
  Simulation simulation(scene);
  expectLimit(simulation.apply(moveTo({1e300, 0, 0})),
              "target: got 1e+300 m from the start of particle 0 of net, expected at most 25 m",
              "limits.max_extent");
  expectLimit(simulation.apply(moveTo({1, 11, 0})),
              "target: got 1100 m/s for particle 0 of net, expected at most 1000 m/s",
              "limits.max_speed");
  EXPECT_TRUE(simulation.apply(moveTo({1, 9.9, 0})).accepted());
  // It has not moved yet: what counts is the way from where it is.
  EXPECT_TRUE(simulation.apply(moveTo({1, -9.9, 0})).accepted());
  EXPECT_NE(simulation.step().status, StepStatus::kFailed);
  expectLimit(simulation.apply(moveTo({1, 9.9, 0})), "1980 m/s", "limits.max_speed");
  EXPECT_TRUE(simulation.apply(moveTo({1, -19.0, 0})).accepted());
  EXPECT_NE(simulation.step().status, StepStatus::kFailed);
  expectLimit(simulation.apply(moveTo({1, -26.0, 0})), "26 m from the start", "limits.max_extent");
}

// A turn moves the particles that are far from the origin of the pin.
TEST(Limits, PinsAreTurnedNoFaster) {
  Scene scene = freeParticles();
  scene.limits.max_speed = 150.0;
  pin(scene, {0, 2});
  Simulation simulation(scene);
  PinCommand turn = moveTo({1, 0, 0});
  turn.target.orientation = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ());
  // Half a turn exchanges the two: 2 m in 0.01 s.
  expectLimit(simulation.apply(turn), "200 m/s for particle 0", "limits.max_speed");
  turn.target.orientation = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ());
  EXPECT_TRUE(simulation.apply(turn).accepted());  // 1.41 m
}

// With a target the particles stay where they are; far from it, rounding would move them.
TEST(Limits, PinsAreMadeNoFartherFromTheirTarget) {
  Simulation simulation(freeParticles());
  PinCommand add;
  add.name = "grasp";
  add.particles = {1};
  add.target.position = Eigen::Vector3d(0, 0, 1e300);
  expectLimit(simulation.apply(add), "target.position: got 1e+300 m", "limits.max_extent");
  add.target.position = Eigen::Vector3d(0, 0, 1e5);
  EXPECT_TRUE(simulation.apply(add).accepted());
  simulation.step();
  // 1e-10: an offset of 1e5 m taken off and added again.
  EXPECT_LT((simulation.state().positions - simulation.model().start.positions).norm(), 1e-10);
}

TEST(Limits, PinsTakeOrientationsOfUnitLengthOnly) {
  Scene scene = freeParticles();
  pin(scene, {0});
  Simulation simulation(scene);
  PinCommand move = moveTo({0, 0, 0});
  for (const double length : {0.0, 1.01, 1e300}) {
    move.target.orientation.coeffs() = Eigen::Vector4d(0, 0, 0, length);
    const CommandResult result = simulation.apply(move);
    EXPECT_EQ(result.refusal, Refusal::kBadValue) << length;
    EXPECT_NE(result.message.find("target.orientation"), std::string::npos) << result.message;
  }
}

// Shapes have time for their way. All of their places count, for a plane those where particles are.
TEST(Limits, ShapesAreLedNoFasterAndNoFarther) {
  Scene scene = freeParticles();
  scene.limits.max_speed = 100.0;
  scene.effects.contact = ContactOptions{
      1000.0, 0.01, {}, 0.001,
      {{"ball", Sphere{{0, 0, 5}, 0.5}, ""},
       {"box", Box{{0, 0, 5}, {0.6, 0.8, 0.0001}, {0, 0, 0}}, ""},
       {"floor", Plane{{0, 0, -5}, {0, 0, 1}}, ""},
       {"rod", Capsule{{0, 0, 5}, {1, 0, 5}, 0.1}, ""}}};
  Simulation simulation(scene);
  const auto move = [&](const std::string& name, const Eigen::Vector3d& target, double angle,
                        double duration) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()));
    return simulation.apply(ShapeCommand{name, {target, turn}, duration});
  };
  expectLimit(move("ball", {1e300, 0, 5}, 0, 1.0),
              "target: got 1e+300 m from the start of shape ball, expected at most 1e+06 m",
              "limits.max_extent");
  expectLimit(move("ball", {2, 0, 5}, 0, 0.0),
              "target: got 200 m/s for shape ball, expected at most 100 m/s", "limits.max_speed");
  expectLimit(move("ball", {2, 0, 5}, 0, 0.015), "133.3", "limits.max_speed");
  EXPECT_TRUE(move("ball", {2, 0, 5}, 0, 0.03).accepted());
  // 1 rad in a step is 100 rad/s: 50 m/s on the ball and on the box, 60 m/s at the ends of the rod.
  EXPECT_TRUE(move("box", {0, 0, 5}, 1.9, 0.0).accepted());
  expectLimit(move("box", {0, 0, 5}, 2.1, 0.0), "105 m/s for shape box", "limits.max_speed");
  EXPECT_TRUE(move("rod", {0.5, 0, 5}, 1.6, 0.0).accepted());
  expectLimit(move("rod", {0.5, 0, 5}, 1.7, 0.0), "102 m/s for shape rod", "limits.max_speed");
  // The particle at x = 2 m is sqrt(29) m from the point of the plane: 100 m/s are 0.186 rad.
  EXPECT_TRUE(move("floor", {0, 0, -5}, 0.18, 0.0).accepted());
  expectLimit(move("floor", {0, 0, -5}, 0.19, 0.0), "m/s for shape floor", "limits.max_speed");
}

TEST(Limits, StatesThatAreSetAreWithinThem) {
  Scene scene = freeParticles();
  pin(scene, {0});
  Simulation simulation(scene);
  const Vectors positions = simulation.state().positions, rest = Vectors::Zero(3, 3);
  Vectors far = positions, fast = rest;
  far(1, 2) = 1e300;
  expectLimit(simulation.setState(far, rest),
              "positions: got 1e+300 m from the start of particle 2 of net", "limits.max_extent");
  fast(0, 1) = 1001.0;
  expectLimit(simulation.setState(positions, fast),
              "velocities: got 1001 m/s for particle 1 of net, expected at most 1000 m/s",
              "limits.max_speed");
  // The pin would take its particle back in the next step.
  far = positions;
  far(2, 0) = 11.0;
  expectLimit(simulation.setState(far, rest), "positions: pin hold would not take them to its",
              "limits.max_speed");
  EXPECT_TRUE(sameBytes(simulation.state().positions, positions));
  far(2, 0) = 9.0;
  fast(0, 1) = 999.0;
  EXPECT_TRUE(simulation.setState(far, fast).accepted());
  EXPECT_NE(simulation.step().status, StepStatus::kFailed);
}

// The timeline's commands are checked when their time has come.
TEST(Limits, HoldForTheTimelineToo) {
  Scene scene = freeParticles();
  pin(scene, {0});
  scene.timeline = {{0.0, moveTo({0, 50.0, 0})}, {0.01, moveTo({0, 5.0, 0})}};
  Simulation simulation(scene);
  std::vector<CommandResult> results;
  simulation.observeTimeline(
      [&](const Command&, const CommandResult& result) { results.push_back(result); });
  for (int n = 0; n < 3; ++n) ASSERT_NE(simulation.step().status, StepStatus::kFailed);
  ASSERT_EQ(results.size(), 2u);
  expectLimit(results[0], "5000 m/s for particle 0 of net", "limits.max_speed");
  EXPECT_TRUE(results[1].accepted());
}

// A point or a radius that no number can hold is no target; it finds what is nearest all the same.
TEST(Limits, PointsFindTheNearestParticleFromAnywhere) {
  Simulation simulation(freeParticles());
  PinCommand add;
  add.name = "grasp";
  add.point = Eigen::Vector3d(1e200, 0, 0);
  add.here = true;
  ASSERT_TRUE(simulation.apply(add).accepted());
  add.name = "all";
  add.point = Eigen::Vector3d(3.0, 0, 0);
  add.radius = 1e300;
  EXPECT_EQ(simulation.apply(add).refusal, Refusal::kConflict);  // it is all particles
}

// Explicit schemes that are within their limits: none of their steps is degraded, driven or not.
TEST(EnergyWatch, IsSilentWhereNothingExplodes) {
  const auto run = [](Scene scene, int steps, const std::function<void(Simulation&, int)>& drive) {
    Simulation simulation(std::move(scene));
    for (int n = 0; n < steps; ++n) {
      drive(simulation, n);
      const StepReport report = simulation.step();
      ASSERT_EQ(report.status, StepStatus::kConverged)
          << name(report.scheme) << " step " << n + 1 << ": " << report.message;
    }
  };
  const auto nothing = [](Simulation&, int) {};
  const auto movePin = [](Simulation& simulation, const Eigen::Vector3d& by) {
    PinCommand move;
    move.action = PinCommand::Action::kMove;
    move.name = "hold";
    move.target = simulation.pins().all().at("hold").target;
    move.target.position += by;
    ASSERT_TRUE(simulation.apply(move).accepted());
  };
  for (const Scheme scheme : {Scheme::kSymplecticEuler, Scheme::kRk4}) {
    // Falls, swings and comes to rest.
    Scene cloth = hangingCloth(6, scheme);
    cloth.rate = 1000.0;
    run(cloth, 3000, nothing);
    // A pin that goes evenly, stops, jumps and goes back.
    run(cloth, 1500, [&](Simulation& simulation, int n) {
      if (n >= 100 && n < 600) movePin(simulation, {0.002, 0, 0.001});
      if (n == 800) movePin(simulation, {0.0, 0.3, 0.0});
      if (n >= 1000 && n % 2 == 0) movePin(simulation, {-0.001, 0, 0});
    });
    // Pushes that come and go, on a cloth that is at rest and on one that swings.
    run(cloth, 2000, [&](Simulation& simulation, int n) {
      if (n % 400 != 0) return;
      ForceCommand push;
      push.particles = {20};
      push.forces = {Eigen::Vector3d(0, 2.0, 0)};
      push.duration = 0.1;
      simulation.apply(push);
    });
    // Pins that are made while it swings, and let go of.
    run(cloth, 1500, [&](Simulation& simulation, int n) {
      PinCommand grab;
      grab.name = "grab";
      grab.particles = {30, 31, 32};
      grab.here = true;
      if (n % 300 == 250) grab.action = PinCommand::Action::kRemove;
      if (n % 300 == 150 || n % 300 == 250) {
        ASSERT_TRUE(simulation.apply(grab).accepted());
      }
    });
    // Wind, and a shape that moves against it.
    Scene windy = cloth;
    windy.effects.wind = WindOptions{Eigen::Vector3d(0, 8, 0), 1.0, 0.3, 1.2, std::nullopt};
    windy.effects.contact =
        ContactOptions{1000.0, 0.01, 0.3, 0.001, {{"ball", Sphere{{0.0, 1.0, -0.3}, 0.2}, ""}}};
    run(windy, 3000, [](Simulation& simulation, int n) {
      if (n % 1000 != 500) return;
      const double y = n % 2000 < 1000 ? -0.3 : 1.0;
      ShapeCommand move{"ball", {Eigen::Vector3d(0, y, -0.3), Eigen::Quaterniond::Identity()}, 0.4};
      ASSERT_TRUE(simulation.apply(move).accepted());
    });
  }
  // Near its limit of w h = 2, the energy of symplectic Euler swings, and does not grow.
  Oscillator oscillator;
  const double w = oscillator.angularFrequency();
  run(oscillator.scene(Scheme::kSymplecticEuler, w / 1.3), 3000, nothing);
  // At rest there is only rounding.
  run(Oscillator{0.3, 40.0, 0.0, 1.0, 0.0}.scene(Scheme::kSymplecticEuler, w), 3000, nothing);
  // A force that sets in on what rests: explicit Euler moves before it has done work.
  run(freeParticles(Scheme::kExplicitEuler), 1000, [](Simulation& simulation, int n) {
    ForceCommand push;
    push.forces = {Eigen::Vector3d(3.0, 0, 0)};
    if (n == 10) simulation.apply(push);
  });
}

// Explicit Euler multiplies the energy of an oscillator by 1 + (w h)^2 in each step. It is said
// once it has doubled, from the energy that there was, and not before.
TEST(EnergyWatch, SeesExplicitEulerDoubleTheEnergy) {
  Oscillator oscillator;
  const double w = oscillator.angularFrequency(), rate = 20.0 * w;
  Simulation simulation(oscillator.scene(Scheme::kExplicitEuler, rate));
  const double start = energy(simulation.model(), simulation.state()).total();
  while (simulation.step().status == StepStatus::kConverged) {
    ASSERT_LT(simulation.state().step, 10000u);
  }
  const double grown = energy(simulation.model(), simulation.state()).total() / start;
  // It is compared where the kinetic energy has a new maximum, once per half swing (63 steps of
  // 1.0025, 1.17 in all), and then in two steps.
  EXPECT_GT(grown, 1.9);
  EXPECT_LT(grown, 2.6);
}

}  // namespace
}  // namespace mass_spring
