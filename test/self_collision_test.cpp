#include "effects/self_collision.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/simulation.h"
#include "passages.h"
#include "problems.h"

// What must not pass through itself, and what must not change where nothing touches.
namespace mass_spring {
namespace {

class Collides : public testing::TestWithParam<Scheme> {};
INSTANTIATE_TEST_SUITE_P(Schemes, Collides,
                         testing::Values(Scheme::kLinearImplicitEuler, Scheme::kImplicitEuler,
                                         Scheme::kTrBdf2, Scheme::kSymplecticEuler),
                         schemeName);

Rope ropeBetween(const Eigen::Vector3d& start, const Eigen::Vector3d& end, int segments) {
  Rope rope;
  rope.start = start;
  rope.end = end;
  rope.segments = segments;
  rope.mass = 0.1;
  rope.axial_rigidity = 20.0;
  rope.damping = 0.05;
  return rope;
}

Scene under(Scheme scheme, double rate) {
  Scene scene;
  scene.rate = rate;
  scene.solver.scheme = scheme;
  scene.solver.newton_tolerance = 1e-3;
  scene.solver.threads = 1;
  scene.effects.gravity = GravityOptions{Eigen::Vector3d(0.0, 0.0, -kGravity)};
  scene.effects.air_drag = AirDragOptions{2e-3};
  return scene;
}

/// Steps for a time [s]. @return how often something has passed through something else, by the ways
/// between places 5 ms apart or a step
template <typename Before>
int passagesIn(Simulation& simulation, double duration, Before before) {
  int count = 0;
  Vectors from = simulation.state().positions;
  double looked = 0.0;
  while (simulation.state().time < duration) {
    before();
    EXPECT_NE(simulation.step().status, StepStatus::kFailed);
    if (simulation.state().time < looked + 0.005) continue;
    count += passages(simulation.model(), from, simulation.state().positions);
    from = simulation.state().positions;
    looked = simulation.state().time;
  }
  return count;
}

// Explicit schemes have to resolve the stiffness of collisions: 2700 rad/s here.
double rateFor(Scheme scheme) { return scheme == Scheme::kSymplecticEuler ? 4000.0 : 100.0; }

/// A sheet held along its middle, whose halves fall and meet below.
Scene fallingHalves(Scheme scheme) {
  Cloth cloth;
  cloth.size = {0.6, 0.2};
  cloth.resolution = {15, 5};
  cloth.mass = 0.05;
  cloth.stiffness = 100.0;
  cloth.shear_stiffness = 10.0;
  cloth.bend_stiffness = 0.5;
  cloth.damping = 0.01;
  Scene scene = under(scheme, rateFor(scheme));
  scene.objects = {{"sheet", {}, cloth}};
  pin(scene, {7, 22, 37, 52, 67});
  return scene;
}

TEST_P(Collides, HalvesOfAFoldedClothStayTwoLayers) {
  for (const bool collides : {false, true}) {
    Scene scene = fallingHalves(GetParam());
    if (collides) scene.effects.self_collision = SelfCollisionOptions{0.01, {}};
    Simulation simulation(scene);
    const int passed = passagesIn(simulation, 1.0, [] {});
    if (collides) {
      EXPECT_EQ(passed, 0);
      for (std::uint32_t row = 0; row < 5; ++row) {
        EXPECT_LT(simulation.state().positions(0, 15 * row),
                  simulation.state().positions(0, 15 * row + 14));
      }
    } else {
      EXPECT_GT(passed, 20);
    }
  }
}

/// A rope across another one, whose ends are then pulled down.
TEST_P(Collides, RopeHangsOnTheRopeThatItCrosses) {
  for (const bool collides : {false, true}) {
    Scene scene = under(GetParam(), rateFor(GetParam()));
    scene.objects = {{"above", {}, ropeBetween({0.003, -0.3, 0.03}, {0.003, 0.3, 0.03}, 24)},
                     {"below", {}, ropeBetween({-0.2, 0.004, 0.0}, {0.2, 0.004, 0.0}, 16)}};
    scene.pins = {{"back", "above", {24}}, {"front", "above", {0}}, {"line", "below", {0, 16}}};
    if (collides) scene.effects.self_collision = SelfCollisionOptions{0.015, {}};
    Simulation simulation(scene);
    const int passed = passagesIn(simulation, 1.0, [&] {
      const double down = std::min(0.15, 0.3 * simulation.state().time);
      for (const bool back : {false, true}) {
        PinCommand move;
        move.action = PinCommand::Action::kMove;
        move.name = back ? "back" : "front";
        move.target.position = {0.003, back ? 0.3 : -0.3, 0.03 - down};
        simulation.apply(move);
      }
    });
    if (collides) {
      EXPECT_EQ(passed, 0);
      EXPECT_GT(simulation.state().positions(2, 12), simulation.state().positions(2, 25 + 8));
    } else {
      EXPECT_GE(passed, 1);
    }
  }
}

/// A rope in a loose overhand knot: a trefoil, cut open at its outside.
Particles looseKnot() {
  constexpr int kFine = 6600, kSegments = 66;
  constexpr double kPi = 3.14159265358979323846, kCut = 0.3, kSize = 0.05;
  const auto at = [&](int n) {
    const double t = kPi + kCut + (2.0 * kPi - 2.0 * kCut) * n / kFine;
    return Eigen::Vector3d(kSize * Eigen::Vector3d(std::sin(t) + 2.0 * std::sin(2.0 * t),
                                                   std::cos(t) - 2.0 * std::cos(2.0 * t),
                                                   -std::sin(3.0 * t)));
  };
  double length = 0.0;
  for (int n = 0; n < kFine; ++n) length += (at(n + 1) - at(n)).norm();
  Particles rope;
  double passed = 0.0;
  for (int n = 0; n <= kFine; ++n) {
    if (n > 0) passed += (at(n) - at(n - 1)).norm();
    const auto count = static_cast<double>(rope.positions.size());
    if (passed >= count * length / kSegments - 1e-12) rope.positions.push_back(at(n));
  }
  rope.velocities.assign(rope.positions.size(), Eigen::Vector3d::Zero());
  rope.masses.assign(rope.positions.size(), 0.003);
  for (std::uint32_t i = 0; i + 1 < rope.positions.size(); ++i) rope.springs.push_back({i, i + 1});
  rope.stiffness.assign(rope.springs.size(), 1000.0);
  rope.damping = std::vector<double>(rope.springs.size(), 0.05);
  return rope;
}

TEST_P(Collides, KnotIsPulledTightAndHolds) {
  const Particles rope = looseKnot();
  const auto last = static_cast<std::uint32_t>(rope.positions.size()) - 1;
  double length = 0.0;
  for (std::uint32_t i = 0; i < last; ++i) {
    length += (rope.positions[i + 1] - rope.positions[i]).norm();
  }
  for (const bool collides : {false, true}) {
    Scene scene = under(GetParam(), rateFor(GetParam()));
    scene.effects.gravity.reset();
    scene.objects = {{"rope", {}, rope}};
    scene.pins = {{"left", "rope", {last}}, {"right", "rope", {0}}};
    if (collides) scene.effects.self_collision = SelfCollisionOptions{0.02, {}};
    Simulation simulation(scene);
    const auto pull = [&] {
      for (const bool left : {false, true}) {
        const Eigen::Vector3d start = rope.positions[left ? last : 0];
        PinCommand move;
        move.action = PinCommand::Action::kMove;
        move.name = left ? "left" : "right";
        const double way = std::min(0.5 * simulation.state().time, 0.45 * length);
        move.target.position = start;
        move.target.position.x() = (left ? -1.0 : 1.0) * std::max(std::abs(start.x()), way);
        simulation.apply(move);
      }
    };
    const int passed = passagesIn(simulation, 2.0, pull);
    const double stretch = maxStretch(simulation.model(), simulation.state());
    if (collides) {
      EXPECT_EQ(passed, 0);
      EXPECT_GT(stretch, 1.04);  // the knot takes more than a tenth of the rope
    } else {
      EXPECT_GE(passed, 1);
      EXPECT_LT(stretch, 1.03);
    }
  }
}

// Far from anything, not a bit may change: also through resets and where nothing is at rest.
TEST_P(Collides, ChangesNothingWhereNothingTouches) {
  Scene scene = hangingCloth(8, GetParam());
  scene.rate = rateFor(GetParam());
  Simulation without(scene);
  // Not below the mean rest length, to which Newton's tolerance refers.
  scene.effects.self_collision = SelfCollisionOptions{0.25, 1e4};
  Simulation with(scene);
  for (int step = 0; step < 10; ++step) {
    without.step();
    with.step();
  }
  EXPECT_EQ(energy(with.model(), with.state()).elastic,
            energy(without.model(), without.state()).elastic);
  EXPECT_TRUE(sameBytes(with.state().positions, without.state().positions));
  EXPECT_TRUE(sameBytes(with.state().velocities, without.state().velocities));
}

TEST_P(Collides, RepeatsItselfToTheBitAfterAReset) {
  Scene scene = fallingHalves(GetParam());
  scene.effects.self_collision = SelfCollisionOptions{0.01, {}};
  Simulation simulation(scene);
  const auto run = [&] {
    while (simulation.state().time < 0.4) simulation.step();
    return simulation.state().positions;
  };
  const Vectors first = run();
  simulation.reset();
  EXPECT_TRUE(sameBytes(first, run()));
}

}  // namespace
}  // namespace mass_spring
