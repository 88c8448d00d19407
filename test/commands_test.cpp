#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "mass_spring_sim/command.h"
#include "mass_spring_sim/simulation.h"
#include "problems.h"

namespace mass_spring {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

ForceCommand force(const Eigen::Vector3d& f, std::vector<std::uint32_t> particles,
                   double duration) {
  ForceCommand command;
  command.forces = {f};
  command.particles = std::move(particles);
  command.duration = duration;
  return command;
}

PinCommand addPin(const std::string& name, std::vector<std::uint32_t> particles) {
  PinCommand command;
  command.name = name;
  command.particles = std::move(particles);
  command.here = true;
  return command;
}

TEST(Forces, ActForTheirDurationOnTheirParticles) {
  for (const SchemeInfo& scheme : schemes()) {
    Simulation simulation(freeParticles(scheme.scheme));
    // 0.025 s at 100 Hz are 2.5 steps: rounded up to 3.
    ASSERT_TRUE(simulation.apply(force(Eigen::Vector3d(0, 3, 0), {1}, 0.025)).accepted());
    for (int n = 1; n <= 6; ++n) {
      EXPECT_EQ(simulation.activeForces(), n <= 3 ? 1u : 0u);
      simulation.step();
      const double expected = 3.0 / 0.5 * 0.01 * std::min(n, 3);
      // 1e-15: a few roundings of numbers below 1.
      EXPECT_NEAR(simulation.state().velocities(1, 1), expected, 1e-15) << scheme.name;
      EXPECT_EQ(simulation.state().velocities.col(0).norm(), 0.0);
      EXPECT_EQ(simulation.state().velocities.col(2).norm(), 0.0);
    }
  }
}

TEST(Forces, DurationZeroIsOneStepAndWholeStepsStayWhole) {
  for (const auto& [duration, steps] : {std::pair(0.0, 1), {0.01, 1}, {0.07, 7}, {0.29, 29}}) {
    Simulation simulation(freeParticles());
    simulation.apply(force(Eigen::Vector3d(1, 0, 0), {}, duration));
    int active = 0;
    for (; simulation.activeForces() > 0; ++active) simulation.step();
    EXPECT_EQ(active, steps) << duration;
  }
}

TEST(Forces, WithoutEndLastUntilReplacedOrCleared) {
  Simulation simulation(freeParticles());
  ForceCommand push = force(Eigen::Vector3d(1, 0, 0), {0}, -1.0);
  push.id = "push";
  simulation.apply(push);
  for (int n = 0; n < 50; ++n) simulation.step();
  EXPECT_NEAR(simulation.state().velocities(0, 0), 50 * 0.01 * 1.0 / 0.5, 1e-13);  // 50 roundings
  push.forces = {Eigen::Vector3d(-2, 0, 0)};
  simulation.apply(push);
  EXPECT_EQ(simulation.activeForces(), 1u);
  for (int n = 0; n < 25; ++n) simulation.step();
  EXPECT_NEAR(simulation.state().velocities(0, 0), 0.0, 1e-13);  // as above
  simulation.clearForces();
  EXPECT_EQ(simulation.activeForces(), 0u);
  const Vectors before = simulation.state().velocities;
  simulation.step();
  EXPECT_TRUE(sameBytes(before, simulation.state().velocities));
}

TEST(Forces, OnePerParticleOrOneForAll) {
  Simulation simulation(freeParticles());
  ForceCommand each;
  each.forces = {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 2, 0), Eigen::Vector3d(0, 0, 3)};
  simulation.apply(each);
  simulation.step();
  for (int i = 0; i < 3; ++i) {
    EXPECT_DOUBLE_EQ(simulation.state().velocities(i, i), (i + 1) * 0.01 / 0.5);
  }
}

struct BadCommand {
  const char* what;
  Command command;
  Refusal refusal;
  const char* message;  // a part of it
};

ForceCommand withObject(ForceCommand command, const std::string& object) {
  command.object = object;
  return command;
}

std::vector<BadCommand> badCommands() {
  ForceCommand two_forces = force(Eigen::Vector3d::Zero(), {0, 1, 2}, 0.0);
  two_forces.forces.emplace_back(1, 0, 0);
  ForceCommand no_forces = force(Eigen::Vector3d::Zero(), {0}, 0.0);
  no_forces.forces.clear();
  PinCommand unknown_move = addPin("nobody", {});
  unknown_move.action = PinCommand::Action::kMove;
  PinCommand not_finite = addPin("new", {1});
  not_finite.target.position.y() = kNaN;
  PinCommand negative = addPin("new", {});
  negative.radius = -1.0;
  PinCommand nothing_near = addPin("new", {});
  nothing_near.point = Eigen::Vector3d(0, 0, 5);
  nothing_near.radius = 1.0;
  const Eigen::Vector3d up(0, 0, 1);
  return {
      {"a NaN", force(Eigen::Vector3d(0, kNaN, 0), {0}, 0), Refusal::kNotFinite, "forces[0]"},
      {"an infinite duration", force(up, {0}, HUGE_VAL), Refusal::kNotFinite, "duration"},
      {"no such object", withObject(force(up, {0}, 0), "sheet"), Refusal::kUnknownObject, "net"},
      {"index too large", force(up, {0, 3}, 0), Refusal::kBadIndex, "expected 0 to 2"},
      {"index twice", force(up, {1, 0, 1}, 0), Refusal::kBadIndex, "particles[2]"},
      {"two forces for three", two_forces, Refusal::kBadLength, "expected 1 or 3"},
      {"no forces", no_forces, Refusal::kBadLength, "got 0"},
      {"too strong", force(Eigen::Vector3d(0, 0, -2e6), {0}, 0), Refusal::kLimit, "max_force"},
      {"squares overflow", force(Eigen::Vector3d(1e200, 0, 0), {0}, 0), Refusal::kLimit, "1e+200"},
      {"no such pin", unknown_move, Refusal::kUnknownPin, "held"},
      {"a pin of that name", addPin("held", {1}), Refusal::kConflict, "held"},
      {"a particle of another pin", addPin("new", {1, 0}), Refusal::kConflict, "held"},
      {"a pin at NaN", not_finite, Refusal::kNotFinite, "target.position"},
      {"a negative radius", negative, Refusal::kBadValue, "radius"},
      {"no particle within the radius", nothing_near, Refusal::kBadValue, "5"},
      {"no name", addPin("", {1}), Refusal::kBadValue, "name"},
      {"a pin of no such particle", addPin("new", {7}), Refusal::kBadIndex, "expected 0 to 2"},
  };
}

TEST(Commands, BadOnesAreRefusedWholeWithTheReason) {
  for (const BadCommand& bad : badCommands()) {
    Simulation simulation(freeParticles()), undisturbed(freeParticles());
    simulation.apply(addPin("held", {0}));
    undisturbed.apply(addPin("held", {0}));
    const CommandResult result = simulation.apply(bad.command);
    EXPECT_EQ(result.refusal, bad.refusal) << bad.what << ": " << result.message;
    EXPECT_NE(result.message.find(bad.message), std::string::npos)
        << bad.what << ": " << result.message;
    EXPECT_EQ(simulation.activeForces(), 0u) << bad.what;
    EXPECT_EQ(simulation.pins().all().size(), 1u) << bad.what;
    simulation.step();
    undisturbed.step();
    EXPECT_TRUE(sameBytes(simulation.state().positions, undisturbed.state().positions));
  }
}

TEST(Pins, HoldAndMoveToTheirTarget) {
  for (const SchemeInfo& scheme : schemes()) {
    Scene scene = hangingCloth(8, scheme.scheme);
    scene.rate = 400.0;
    Simulation simulation(scene);
    const Vectors start = simulation.model().start.positions;
    for (int n = 0; n < 50; ++n) simulation.step();
    // 1e-15: an offset taken off and added again.
    EXPECT_LT((simulation.state().positions.col(0) - start.col(0)).norm(), 1e-15) << scheme.name;
    PinCommand move = addPin("hold", {});
    move.action = PinCommand::Action::kMove;
    move.target.position = simulation.pins().all().at("hold").target.position;
    move.target.position.x() += 0.01;
    move.target.orientation = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ());
    ASSERT_TRUE(simulation.apply(move).accepted());
    ASSERT_NE(simulation.step().status, StepStatus::kFailed);
    // Half a turn about the middle of the two corners exchanges them.
    const Eigen::Vector3d shift(0.01, 0, 0);
    EXPECT_LT((simulation.state().positions.col(0) - start.col(7) - shift).norm(), 1e-15);
    EXPECT_LT((simulation.state().positions.col(7) - start.col(0) - shift).norm(), 1e-15);
  }
}

TEST(Pins, FoundByPointAndRadius) {
  Simulation simulation(hangingCloth(11, Scheme::kImplicitEuler));
  PinCommand nearest = addPin("nearest", {});
  nearest.point = Eigen::Vector3d(0.01, 0.02, 0.3);  // above the middle, particle 60
  ASSERT_TRUE(simulation.apply(nearest).accepted());
  EXPECT_EQ(simulation.pins().all().at("nearest").particles, std::vector<std::uint32_t>{60});
  PinCommand around = addPin("around", {});
  around.point = Eigen::Vector3d(0.5, 0.5, 0.0);  // the last corner, spacing 0.1
  around.radius = 0.11;
  ASSERT_TRUE(simulation.apply(around).accepted());
  EXPECT_EQ(simulation.pins().all().at("around").particles,
            (std::vector<std::uint32_t>{109, 119, 120}));
}

TEST(Pins, AddedWithATargetKeepTheirOffsets) {
  Simulation simulation(freeParticles());
  PinCommand grasp = addPin("grasp", {0, 1});
  grasp.here = false;
  grasp.target.position = Eigen::Vector3d(0, 1, 0);
  simulation.apply(grasp);
  simulation.step();
  EXPECT_LT((simulation.state().positions - simulation.model().start.positions).norm(), 1e-15);
  grasp.action = PinCommand::Action::kMove;
  grasp.target.orientation = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ());
  simulation.apply(grasp);
  simulation.step();
  // Offsets (0,-1,0) and (1,-1,0), turned by 90 degrees about z and put at (0,1,0).
  EXPECT_LT((simulation.state().positions.col(0) - Eigen::Vector3d(1, 1, 0)).norm(), 1e-15);
  EXPECT_LT((simulation.state().positions.col(1) - Eigen::Vector3d(1, 2, 0)).norm(), 1e-15);
}

TEST(Pins, AllPinnedNeedsNoSolve) {
  for (const SchemeInfo& scheme : schemes()) {
    Scene scene = hangingCloth(5, scheme.scheme);
    scene.pins[0].particles.resize(25);
    for (std::uint32_t i = 0; i < 25; ++i) scene.pins[0].particles[i] = i;
    Simulation simulation(scene);
    const StepReport report = simulation.step();
    EXPECT_EQ(report.status, StepStatus::kConverged);
    EXPECT_EQ(report.linear_iterations + report.factorizations, 0u);
    EXPECT_LT((simulation.state().positions - simulation.model().start.positions).norm(), 1e-15);
  }
}

TEST(Pins, TeleportedStayFinite) {
  for (Scheme scheme : {Scheme::kLinearImplicitEuler, Scheme::kImplicitEuler}) {
    Simulation simulation(hangingCloth(8, scheme));
    PinCommand move = addPin("hold", {});
    move.action = PinCommand::Action::kMove;
    move.target.position = Eigen::Vector3d(0, -0.5, 1.0);
    simulation.apply(move);
    for (int n = 0; n < 120; ++n) ASSERT_NE(simulation.step().status, StepStatus::kFailed);
    EXPECT_LT(maxStretch(simulation.model(), simulation.state()), 1.5);
  }
}

// Whoever knows the frame says so with each move; nobody else gets in between.
TEST(Pins, ThoseThatFollowAFrameAreLedByIt) {
  Simulation simulation(freeParticles());
  PinCommand pin = addPin("grip", {1});
  pin.follow_frame = "tool";
  ASSERT_TRUE(simulation.apply(pin).accepted());
  pin.action = PinCommand::Action::kMove;
  pin.target.position = Eigen::Vector3d(1, 2, 3);
  ASSERT_TRUE(simulation.apply(pin).accepted());
  simulation.step();
  EXPECT_EQ(simulation.state().positions.col(1), pin.target.position);
  for (const char* other : {"", "world"}) {
    pin.follow_frame = other;
    EXPECT_EQ(simulation.apply(pin).refusal, Refusal::kConflict);
  }
  pin.action = PinCommand::Action::kRemove;
  EXPECT_TRUE(simulation.apply(pin).accepted());
}

TEST(Timeline, TakesEffectAtItsTimes) {
  Scene scene = freeParticles();
  scene.timeline.push_back({0.02, force(Eigen::Vector3d(5, 0, 0), {0}, 0.0)});
  scene.timeline.push_back({0.035, addPin("grab", {1})});
  scene.timeline.push_back({0.06, force(Eigen::Vector3d(5, 0, 0), {9}, 0.0)});
  for (int run = 0; run < 2; ++run) {
    Simulation simulation(scene);
    std::vector<std::pair<std::uint64_t, bool>> seen;
    simulation.observeTimeline([&](const Command&, const CommandResult& result) {
      seen.emplace_back(simulation.state().step, result.accepted());
    });
    if (run == 1) {
      for (int n = 0; n < 5; ++n) simulation.step();
      simulation.reset();
      seen.clear();
    }
    for (int n = 0; n < 10; ++n) {
      simulation.step();
      EXPECT_EQ(simulation.state().velocities(0, 0) > 0.0, n >= 2);
    }
    EXPECT_EQ(seen,
              (std::vector<std::pair<std::uint64_t, bool>>{{2, true}, {4, true}, {6, false}}));
  }
}

TEST(Timeline, LetsGoOfForcesAndPins) {
  Scene scene = freeParticles();
  scene.timeline = {{0.0, force(Eigen::Vector3d(5, 0, 0), {0}, -1.0)},
                    {0.0, addPin("grab", {1})},
                    {0.03, ClearCommand{ClearCommand::What::kForces}},
                    {0.05, ClearCommand{ClearCommand::What::kPins}}};
  Simulation simulation(scene);
  for (int n = 1; n <= 7; ++n) {
    simulation.step();
    EXPECT_EQ(simulation.activeForces(), n <= 3 ? 1u : 0u) << n;
    EXPECT_EQ(simulation.pins().all().size(), n <= 5 ? 1u : 0u) << n;
  }
  EXPECT_NEAR(simulation.state().velocities(0, 0), 3 * 0.01 * 5.0 / 0.5, 1e-14);  // 3 roundings
}

}  // namespace
}  // namespace mass_spring
