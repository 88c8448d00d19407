#include "effects/contact.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/simulation.h"
#include "problems.h"
#include "sanitizers.h"

// Contact, friction and air drag against what is known of them in closed form.
namespace mass_spring {
namespace {

class DissipativeScheme : public testing::TestWithParam<Scheme> {};
INSTANTIATE_TEST_SUITE_P(Schemes, DissipativeScheme,
                         testing::Values(Scheme::kLinearImplicitEuler, Scheme::kImplicitEuler,
                                         Scheme::kBdf2, Scheme::kTrBdf2),
                         schemeName);

/// One particle of 0.1 kg.
Scene particleScene(const Eigen::Vector3d& position, Scheme scheme, double rate) {
  Particles one;
  one.positions = {position};
  one.velocities = {Eigen::Vector3d::Zero()};
  one.masses = {0.1};
  Scene scene = netScene(one, scheme, rate);
  scene.effects.gravity = GravityOptions{Eigen::Vector3d(0.0, 0.0, -kGravity)};
  return scene;
}

ContactOptions contactWith(std::vector<ContactShape> shapes) {
  ContactOptions options;
  options.stiffness = 1000.0;
  options.thickness = 0.01;
  options.shapes = std::move(shapes);
  return options;
}

TEST_P(DissipativeScheme, ParticleRestsAtItsWeightOverTheStiffness) {
  Scene scene = particleScene({0.0, 0.0, 0.05}, GetParam(), 200.0);
  scene.effects.contact = contactWith({{"floor", Plane{{0, 0, 0}, {0, 0, 1}}}});
  scene.effects.air_drag = AirDragOptions{1.0};  // or it would bounce for long
  Simulation simulation(scene);
  for (int step = 0; step < 2000; ++step) {
    ASSERT_NE(simulation.step().status, StepStatus::kFailed);
  }
  // 1e-9: what is left of a bounce after 10 s, e^-50, and the tolerance of Newton's method.
  EXPECT_NEAR(simulation.state().positions(2, 0), 0.01 - 0.1 * kGravity / 1000.0, 1e-9);
}

TEST_P(DissipativeScheme, AirDragGivesTheTerminalVelocity) {
  Scene scene = particleScene({0.0, 0.0, 0.0}, GetParam(), 100.0);
  scene.effects.air_drag = AirDragOptions{0.5};
  Simulation simulation(scene);
  for (int step = 0; step < 1000; ++step) simulation.step();
  // After 10 s, 50 time constants; tolerance: Newton's and rounding.
  EXPECT_NEAR(simulation.state().velocities(2, 0), -0.1 * kGravity / 0.5, 1e-7);
}

/// A particle on a slope, at rest where it floats; returns it after a second.
State onSlope(Scheme scheme, double slope, double friction) {
  const Eigen::Vector3d normal(-std::sin(slope), 0.0, std::cos(slope));
  const double depth = 0.1 * kGravity * std::cos(slope) / 1000.0;
  Scene scene = particleScene((0.01 - depth) * normal, scheme, 200.0);
  scene.effects.contact = contactWith({{"slope", Plane{{0, 0, 0}, normal}}});
  scene.effects.contact->friction = friction;
  Simulation simulation(scene);
  for (int step = 0; step < 200; ++step) simulation.step();
  return simulation.state();
}

TEST_P(DissipativeScheme, BlockSticksBelowTheAngleOfFriction) {
  const double friction = 0.5;
  // It creeps with less than the slip velocity of 1 mm/s.
  EXPECT_LT(onSlope(GetParam(), std::atan(0.4), friction).positions.norm(), 0.012);
  EXPECT_LT(onSlope(GetParam(), std::atan(0.4), friction).velocities.norm(), 0.001);
}

TEST_P(DissipativeScheme, BlockSlidesAboveTheAngleOfFriction) {
  const double friction = 0.5, slope = std::atan(0.8);
  const State state = onSlope(GetParam(), slope, friction);
  const double acceleration = kGravity * (std::sin(slope) - friction * std::cos(slope));
  // Full friction from 1 mm/s on, which it has in the first step of this second: less is missing
  // than what gravity does in that step. Linearized steps brake a little more until they are sure
  // not to stop what slides, here for the first ten.
  const double step = kGravity * std::sin(slope) / 200.0;
  EXPECT_NEAR(state.velocities.norm(), acceleration,
              GetParam() == Scheme::kLinearImplicitEuler ? 4.0 * step : step);
  EXPECT_LT(state.velocities(0, 0), 0.0);  // downhill
}

// Braked by mu m g, a sliding particle stops after v^2 / (2 mu g), and does not come back.
TEST_P(DissipativeScheme, SlidingParticleStops) {
  Scene scene = particleScene({0.0, 0.0, 0.01 - 0.1 * kGravity / 1000.0}, GetParam(), 500.0);
  std::get<Particles>(scene.objects[0].shape).velocities = {Eigen::Vector3d(1.0, 0.0, 0.0)};
  scene.effects.contact = contactWith({{"floor", Plane{{0, 0, 0}, {0, 0, 1}}}});
  scene.effects.contact->friction = 0.3;
  Simulation simulation(scene);
  double speed = 1.0;
  for (int step = 0; step < 500; ++step) {
    simulation.step();
    const double now = simulation.state().velocities(0, 0);
    // Schemes of second order may swing through a standstill, but no faster than what is slow.
    EXPECT_GE(now, -scene.effects.contact->slip_velocity);
    EXPECT_LE(now, std::max(speed, 0.0) + 0.1 * scene.effects.contact->slip_velocity);
    speed = now;
  }
  EXPECT_LT(std::abs(speed), 1e-4);
  // First-order schemes misjudge the way by half a step at full speed.
  EXPECT_NEAR(simulation.state().positions(0, 0), 1.0 / (2.0 * 0.3 * kGravity), 1.5 / 500.0);
}

Scene drapedCloth(Scheme scheme, std::vector<ContactShape> shapes) {
  Cloth cloth;
  cloth.size = {0.6, 0.6};
  cloth.resolution = {11, 11};
  cloth.position = {0.0, 0.0, 0.55};
  cloth.mass = 0.1;
  cloth.stiffness = 100.0;
  cloth.shear_stiffness = 30.0;
  cloth.bend_stiffness = 2.0;
  cloth.damping = 0.05;
  Scene scene;
  scene.objects.push_back({"sheet", Object().color, cloth});
  scene.rate = 60.0;
  scene.solver.scheme = scheme;
  scene.solver.newton_tolerance = 1e-3;
  scene.solver.max_newton_iterations = 100;
  scene.effects.gravity = GravityOptions{Eigen::Vector3d(0.0, 0.0, -kGravity)};
  scene.effects.air_drag = AirDragOptions{4e-3};
  scene.effects.contact = contactWith(std::move(shapes));
  scene.effects.contact->friction = 0.6;
  return scene;
}

class DrapedCloth : public testing::TestWithParam<Scheme> {};
INSTANTIATE_TEST_SUITE_P(Schemes, DrapedCloth,
                         testing::ValuesIn(underSanitizers()
                                               ? std::vector{Scheme::kLinearImplicitEuler}
                                               : std::vector{Scheme::kLinearImplicitEuler,
                                                             Scheme::kTrBdf2}),
                         schemeName);

// No particle is ever deeper than the thickness, and all is at rest in the end.
TEST_P(DrapedCloth, LiesOnASphereAndOnABox) {
  for (const ContactShape& shape :
       {ContactShape{"ball", Sphere{{0.01, 0.02, 0.3}, 0.2}},
        ContactShape{"table", Box{{0.0, 0.0, 0.4}, {0.3, 0.3, 0.1}, {0.0, 0.0, 0.2}}}}) {
    Simulation simulation(drapedCloth(GetParam(), {shape}));
    const PlacedShape body(simulation.model().shapes[0], simulation.state().effects.shapes[0], 0.0);
    double deepest = 0.0;
    for (int step = 0; step < 240; ++step) {
      ASSERT_NE(simulation.step().status, StepStatus::kFailed);
      for (Eigen::Index i = 0; i < simulation.state().positions.cols(); ++i) {
        deepest = std::max(deepest, -body.distance(simulation.state().positions.col(i)));
      }
    }
    EXPECT_LE(deepest, 0.0) << shape.name;  // of the shape itself, within the thickness
    EXPECT_LT(maxSpeed(simulation.state()), 0.05) << shape.name;
    // It has not slid off.
    EXPECT_GT(simulation.state().positions.row(2).maxCoeff(), 0.45) << shape.name;
  }
}

// Below the slip velocity friction is a stiff damper, also where contact begins at the surface: an
// explicit step of a hundredth of a second would not survive it.
TEST(Friction, IsStiffForAutoWithAndWithoutThickness) {
  for (const double thickness : {0.0, 0.01}) {
    Scene scene = particleScene({0.0, 0.0, 0.0}, Scheme::kAuto, 100.0);
    scene.effects.contact = contactWith({{"floor", Plane{{0, 0, 0}, {0, 0, 1}}}});
    scene.effects.contact->thickness = thickness;
    EXPECT_FALSE(info(buildModel(scene).solver.scheme).implicit) << thickness;
    scene.effects.contact->friction = 0.5;
    EXPECT_TRUE(info(buildModel(scene).solver.scheme).implicit) << thickness;
  }
}

TEST(Contact, RefusesWhatNoReaderHasSeen) {
  Scene scene = particleScene({0.0, 0.0, 0.0}, Scheme::kTrBdf2, 100.0);
  scene.effects.contact = contactWith({{"floor", Plane{{0, 0, 0}, {0, 0, 1}}}});
  const auto problem = [](const Scene& refused) -> std::string {
    try {
      Simulation simulation(refused);
    } catch (const SceneError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(problem(scene), "");
  scene.effects.contact->slip_velocity = 0.0;
  EXPECT_EQ(problem(scene), "effects.contact.slip_velocity: got 0, expected a number > 0 (m/s)");
  scene.effects.contact.reset();
  scene.effects.air_drag = AirDragOptions{-1.0};
  EXPECT_EQ(problem(scene), "effects.air_drag.coefficient: got -1, expected a number >= 0 (N s/m)");
}

// Gravity and drag do not know of it, springs neither: a shape far away changes nothing.
TEST(Contact, FarAwayChangesNoBit) {
  for (const Scheme scheme : allSchemes()) {
    Scene scene = drapedCloth(scheme, {});
    std::get<Cloth>(scene.objects[0].shape).resolution = {5, 5};
    scene.rate = 1000.0;
    Scene without = scene;
    scene.effects.contact = contactWith({{"floor", Plane{{0.0, 0.0, -100.0}, {0.0, 0.0, 1.0}}}});
    without.effects.contact.reset();
    Simulation a(scene), b(without);
    for (int step = 0; step < 20; ++step) a.step(), b.step();
    EXPECT_TRUE(a.state().positions == b.state().positions) << name(scheme);
    EXPECT_TRUE(a.state().velocities == b.state().velocities) << name(scheme);
  }
}

TEST(AirDrag, WithoutCoefficientChangesNoBit) {
  for (const Scheme scheme : allSchemes()) {
    Scene scene = drapedCloth(scheme, {});
    std::get<Cloth>(scene.objects[0].shape).resolution = {5, 5};
    scene.rate = 1000.0;
    scene.effects.contact.reset();
    Scene without = scene;
    scene.effects.air_drag = AirDragOptions{0.0};
    without.effects.air_drag.reset();
    Simulation a(scene), b(without);
    for (int step = 0; step < 20; ++step) a.step(), b.step();
    EXPECT_TRUE(a.state().positions == b.state().positions) << name(scheme);
  }
}

/// Runs until nothing moves faster than that [m/s].
void settle(Simulation& simulation, double slow) {
  for (int step = 0; step < 20000 && (step < 100 || maxSpeed(simulation.state()) > slow); ++step) {
    simulation.step();
  }
}

TEST(Wrenches, OfPinsBalanceTheWeightAndTheMomentOfAHangingRope) {
  Rope rope;
  rope.start = {0.0, 0.0, 1.0};
  rope.end = {0.8, 0.0, 1.0};
  rope.segments = 20;
  rope.mass = 0.3;
  rope.stiffness = 500.0;
  rope.damping = 5.0;
  Scene scene;
  scene.objects.push_back({"rope", Object().color, rope});
  scene.pins = {{"left", "rope", {0}}, {"right", "rope", {20}}};
  scene.rate = 20.0;
  scene.solver.scheme = Scheme::kImplicitEuler;
  scene.effects.gravity = GravityOptions{Eigen::Vector3d(0.0, 0.0, -kGravity)};
  scene.effects.air_drag = AirDragOptions{0.1};
  Simulation simulation(scene);
  settle(simulation, 1e-10);
  const auto wrenches = simulation.pinWrenches();
  const Eigen::Vector3d left = wrenches.at("left").force, right = wrenches.at("right").force;
  // What the forces of the free particles leave, at accelerations of 1e-10 m/s in a step.
  EXPECT_LT((left + right - Eigen::Vector3d(0.0, 0.0, -0.3 * kGravity)).norm(),
            1e-6 * 0.3 * kGravity);
  // The same accelerations, against a pull of some newtons.
  EXPECT_NEAR(left.x(), -right.x(), 1e-6);
  EXPECT_GT(left.x(), 1.0);  // pulled towards the middle
}

TEST(Wrenches, OfShapesBalanceTheWeightOfWhatLiesOnThem) {
  Scene scene = drapedCloth(Scheme::kLinearImplicitEuler, {{"floor", Plane{{0, 0, 0}, {0, 0, 1}}},
                                                           {"ball", Sphere{{0.0, 0.0, 0.3}, 0.2}}});
  Simulation simulation(scene);
  settle(simulation, 1e-4);
  const auto wrenches = simulation.shapeWrenches();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& [name, wrench] : wrenches) sum += wrench.force;
  EXPECT_LT((sum - Eigen::Vector3d(0.0, 0.0, -0.1 * kGravity)).norm(), 1e-3 * 0.1 * kGravity);
  EXPECT_LT(wrenches.at("ball").force.z(), -0.5 * 0.1 * kGravity);
  // Normal forces have no moment about the middle of a ball.
  EXPECT_LT(wrenches.at("ball").torque.norm(), 0.2 * 0.02);
}

// A rope slung over a bar slips where the tensions differ by more than e^(mu phi) (Euler,
// Eytelwein).
TEST(Friction, CapstanHoldsUpToTheExponentialOfTheAngle) {
  constexpr double kFriction = 0.3;
  const double limit = std::exp(kFriction * M_PI);
  const auto slips = [&](double ratio) {
    constexpr int kSegments = 120;
    constexpr double kRadius = 0.1, kThickness = 0.005, kTail = 0.15;
    Particles rope;
    const double way = M_PI * (kRadius + kThickness), length = way + 2.0 * kTail;
    for (int i = 0; i <= kSegments; ++i) {
      const double s = length * i / kSegments - kTail;
      const double angle = std::clamp(s / (kRadius + kThickness), 0.0, M_PI);
      const double below = s < 0.0 ? s : s > way ? way - s : 0.0;
      rope.positions.emplace_back(-(kRadius + kThickness) * std::cos(angle), 0.0,
                                  (kRadius + kThickness) * std::sin(angle) + below);
      rope.velocities.push_back(Eigen::Vector3d::Zero());
      rope.masses.push_back(1e-5);
      if (i > 0) {
        rope.springs.push_back({static_cast<std::uint32_t>(i - 1), static_cast<std::uint32_t>(i)});
        rope.stiffness.push_back(2e4);
      }
    }
    // Both ends carry a weight, against which the rope's own is nothing.
    rope.masses.front() = 0.1;
    rope.masses.back() = 0.1 * ratio;
    Scene scene = netScene(rope, Scheme::kImplicitEuler, 1000.0);
    scene.solver.max_newton_iterations = 100;
    scene.effects.gravity = GravityOptions{Eigen::Vector3d(0.0, 0.0, -kGravity)};
    scene.effects.air_drag = AirDragOptions{0.02};
    scene.effects.contact =
        contactWith({{"bar", Capsule{{0.0, -0.1, 0.0}, {0.0, 0.1, 0.0}, kRadius}}});
    scene.effects.contact->thickness = kThickness;
    scene.effects.contact->stiffness = 1e4;
    scene.effects.contact->friction = kFriction;
    Simulation simulation(scene);
    for (int step = 0; step < 200; ++step) simulation.step();
    const double before = simulation.state().positions(2, kSegments);
    for (int step = 0; step < 100; ++step) simulation.step();
    // Sticking, it creeps by less than a millimeter per second; slipping, it gathers way.
    return before - simulation.state().positions(2, kSegments) > 5e-4;
  };
  EXPECT_FALSE(slips(0.95 * limit));
  EXPECT_TRUE(slips(1.05 * limit));
}

}  // namespace
}  // namespace mass_spring
