#include <gtest/gtest.h>

#include <cmath>

#include "effects/contact.h"
#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/simulation.h"
#include "problems.h"

// Shapes that move: a belt, a turntable, a lift, and what commands do to them.
namespace mass_spring {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kMass = 0.1, kPush = 1000.0, kThickness = 0.01;

Pose poseAt(const Eigen::Vector3d& position, double angle, const Eigen::Vector3d& axis) {
  return {position, Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis.normalized()))};
}

TEST(RigidMotion, GoesEvenlyFromPoseToPose) {
  const Pose from = poseAt({1.0, 2.0, 3.0}, 0.4, {1.0, 0.0, 1.0});
  const Pose to = poseAt({2.0, 0.0, 3.5}, 1.9, {0.0, 1.0, 2.0});
  const RigidMotion motion(from, to, 2.0, 0.5);
  EXPECT_EQ(motion.at(1.0).position, from.position);
  EXPECT_EQ(motion.at(2.0).orientation.coeffs(), from.orientation.coeffs());
  EXPECT_EQ(motion.at(2.5).position, to.position);
  EXPECT_EQ(motion.at(2.5).orientation.coeffs(), to.orientation.coeffs());
  EXPECT_EQ(motion.at(9.0).position, to.position);
  EXPECT_TRUE(motion.lasts(2.5));
  EXPECT_FALSE(motion.lasts(2.51));
  // Half way in time is half way round; tolerance: rounding.
  const Pose middle = motion.at(2.25);
  EXPECT_LT((middle.position - 0.5 * (from.position + to.position)).norm(), 1e-14);
  EXPECT_NEAR(middle.orientation.angularDistance(from.orientation),
              middle.orientation.angularDistance(to.orientation), 1e-14);
  EXPECT_LT(middle.orientation.angularDistance(from.orientation), 0.5 * kPi);
}

// The velocity of a place on a body is the rate at which that place moves.
TEST(Shape, VelocityIsThatOfThePlacesOnTheBody) {
  const Shape shape({"box", Box{{0.1, 0.2, 0.3}, {0.4, 0.5, 0.6}, {0.3, -0.2, 0.7}}});
  const RigidMotion motion(shape.start(), poseAt({1.0, 0.5, -0.5}, 2.0, {1.0, -1.0, 0.5}), 1.0,
                           2.0);
  constexpr double kAhead = 1e-6;
  const Eigen::Vector3d local(0.3, -0.2, 0.1);
  const auto place = [&](double time) -> Eigen::Vector3d {
    const PlacedShape placed(shape, motion, time);
    EXPECT_TRUE(placed.moves());
    return placed.geometryPose() * local;
  };
  const Eigen::Vector3d rate = (place(1.7 + kAhead) - place(1.7 - kAhead)) / (2.0 * kAhead);
  const Eigen::Vector3d velocity = PlacedShape(shape, motion, 1.7).velocityAt(place(1.7));
  // Truncation 1e-12, rounding 1e-16 / 1e-6.
  EXPECT_LT((rate - velocity).norm(), 1e-8);
  EXPECT_GT(velocity.norm(), 0.1);
  const PlacedShape after(shape, motion, 3.5);
  EXPECT_FALSE(after.moves());
  EXPECT_EQ(after.velocityAt({1.0, 1.0, 1.0}), Eigen::Vector3d::Zero());
}

/// A particle on a block whose top is at z = 0, as deep as its weight presses it.
Scene blockScene(Scheme scheme, double rate, double friction) {
  Particles one;
  one.positions = {Eigen::Vector3d(0.2, 0.0, kThickness - kMass * kGravity / kPush)};
  one.velocities = {Eigen::Vector3d::Zero()};
  one.masses = {kMass};
  Scene scene = netScene(one, scheme, rate);
  scene.effects.gravity = GravityOptions{Eigen::Vector3d(0.0, 0.0, -kGravity)};
  ContactOptions& contact = scene.effects.contact.emplace();
  contact.stiffness = kPush;
  contact.thickness = kThickness;
  contact.friction = friction;
  contact.shapes = {{"block", Box{{0, 0, -0.5}, {20.0, 20.0, 1.0}}}};
  return scene;
}

ShapeCommand move(const Eigen::Vector3d& by, double angle, double duration) {
  return {"block", poseAt(Eigen::Vector3d(0.0, 0.0, -0.5) + by, angle, {0, 0, 1}), duration};
}

class MovingShapes : public testing::TestWithParam<Scheme> {};
INSTANTIATE_TEST_SUITE_P(Schemes, MovingShapes,
                         testing::Values(Scheme::kLinearImplicitEuler, Scheme::kImplicitEuler,
                                         Scheme::kBdf2, Scheme::kTrBdf2),
                         schemeName);

// A belt of speed U takes along what lies on it: mu g t, until it is as fast, after the way
// U^2 / (2 mu g); from then on it stays with the belt.
TEST_P(MovingShapes, BeltTakesAParticleAlong) {
  constexpr double kRate = 500.0, kFriction = 0.3, kSpeed = 1.0;
  Simulation simulation(blockScene(GetParam(), kRate, kFriction));
  ASSERT_TRUE(simulation.apply(move({2.0 * kSpeed, 0.0, 0.0}, 0.0, 2.0)).accepted());
  for (int step = 1; step <= 1000; ++step) {
    ASSERT_EQ(simulation.step().status, StepStatus::kConverged) << step;
    const double expected = std::min(kFriction * kGravity * step / kRate, kSpeed);
    // Two steps of acceleration: where the sliding begins and ends within a step.
    EXPECT_NEAR(simulation.state().velocities(0, 0), expected, 2.0 * kFriction * kGravity / kRate);
  }
  const double missed = kSpeed * kSpeed / (2.0 * kFriction * kGravity);
  // Half a step at full speed, as first-order schemes misjudge it, and the creep of 1 mm/s.
  EXPECT_NEAR(simulation.state().positions(0, 0), 0.2 + 2.0 - missed, 1.0 / kRate + 2e-3);
  EXPECT_NEAR(simulation.state().positions(2, 0), kThickness - kMass * kGravity / kPush, 1e-6);
}

// On a turntable with enough friction, a particle goes round with it.
TEST_P(MovingShapes, TurntableTakesAParticleRound) {
  constexpr double kRate = 500.0;
  Simulation simulation(blockScene(GetParam(), kRate, 2.0));
  ASSERT_TRUE(simulation.apply(move(Eigen::Vector3d::Zero(), 0.5 * kPi, 1.0)).accepted());
  for (int step = 0; step < 500; ++step) simulation.step();
  // It starts from rest, and slips v^2 / (2 mu g) until it is as fast as the table (mu = 2); then
  // it creeps with less than the slip velocity of 1 mm/s for the rest of the second.
  const double speed = 0.2 * 0.5 * kPi, slipped = speed * speed / (2.0 * 2.0 * kGravity);
  EXPECT_LT((simulation.state().positions.col(0).head<2>() - Eigen::Vector2d(0.0, 0.2)).norm(),
            slipped + 1e-3);
}

// What rises evenly carries just the weight; the sensor in it feels that.
TEST_P(MovingShapes, LiftCarriesTheWeight) {
  Scene scene = blockScene(GetParam(), 200.0, 0.3);
  scene.effects.air_drag = AirDragOptions{0.2};  // what the start shakes comes to rest
  Simulation simulation(scene);
  ASSERT_TRUE(simulation.apply(move({0.0, 0.0, 2.0}, 0.0, 10.0)).accepted());
  for (int step = 0; step < 1500; ++step) simulation.step();
  const double rise = 0.2, drag = 0.2 * rise;  // m/s, N
  // After 7.5 s: e^-7.5 of the shaking that the start made, of 1 mm and 0.2 m/s at 16 Hz.
  EXPECT_NEAR(simulation.state().velocities(2, 0), rise, 1e-3);
  const Wrench wrench = simulation.shapeWrenches().at("block");
  EXPECT_NEAR(wrench.force.z(), -(kMass * kGravity + drag), 1e-2);
  // About the center of the block, 0.2 m aside of the particle.
  EXPECT_NEAR(wrench.torque.y(), 0.2 * (kMass * kGravity + drag), 2e-3);
}

// A shape that is put elsewhere in one step, through the particle: finite, and no more energy than
// pressing the particle in there takes.
TEST_P(MovingShapes, ShapeThatJumpsIntoAParticlePushesItOut) {
  Simulation simulation(blockScene(GetParam(), 100.0, 0.3));
  ASSERT_TRUE(simulation.apply(move({0.0, 0.0, 0.05}, 0.0, 0.0)).accepted());
  const double pressed = 0.5 * kPush * 0.06 * 0.06;
  for (int step = 0; step < 300; ++step) {
    ASSERT_NE(simulation.step().status, StepStatus::kFailed);
    const Energy now = energy(simulation.model(), simulation.state());
    EXPECT_LE(now.kinetic + now.elastic, pressed);
  }
  EXPECT_GT(simulation.state().positions(2, 0), 0.05);
}

Scene belt() {
  Scene scene = blockScene(Scheme::kTrBdf2, 100.0, 0.3);
  scene.timeline.push_back({0.05, move({1.0, 0.0, 0.0}, 0.3, 0.2)});
  return scene;
}

Pose poseOfShape(const Simulation& simulation) {
  return simulation.state().effects.shapes[0].at(simulation.state().time);
}

TEST(ShapeCommands, ResetPutsShapesBackAndTheRunRepeatsItself) {
  Simulation simulation(belt());
  for (int step = 0; step < 40; ++step) simulation.step();
  const Vectors first = simulation.state().positions;
  const Pose end = poseOfShape(simulation);
  EXPECT_EQ(end.position, Eigen::Vector3d(1.0, 0.0, -0.5));
  simulation.reset();
  EXPECT_EQ(poseOfShape(simulation).position, Eigen::Vector3d(0.0, 0.0, -0.5));
  for (int step = 0; step < 40; ++step) simulation.step();
  EXPECT_TRUE(sameBytes(first, simulation.state().positions));
}

// Reloaded in the middle of the motion, the shape goes on; one that was moved in the scene does
// not.
TEST(ShapeCommands, MotionGoesOnInAnotherSimulation) {
  Simulation whole(belt()), first(belt()), second(belt());
  for (int step = 0; step < 40; ++step) whole.step();
  for (int step = 0; step < 12; ++step) first.step();
  ASSERT_TRUE(second.continueFrom(first));
  for (int step = 12; step < 40; ++step) second.step();
  // What the solver remembers of earlier steps is forgotten: Newton's tolerance.
  EXPECT_LT((whole.state().positions - second.state().positions).norm(), 1e-6);

  Scene moved = belt();
  std::get<Box>(moved.effects.contact->shapes[0].geometry).center.y() = 0.25;
  Simulation other(moved);
  ASSERT_TRUE(other.continueFrom(first));
  EXPECT_EQ(poseOfShape(other).position, Eigen::Vector3d(0.0, 0.25, -0.5));
}

TEST(ShapeCommands, BadOnesAreRefusedByName) {
  Simulation simulation(belt());
  const auto refused = [&](const ShapeCommand& command) {
    const CommandResult result = simulation.apply(command);
    EXPECT_FALSE(result.message.empty() && !result.accepted());
    return result.refusal;
  };
  ShapeCommand command = move(Eigen::Vector3d::Zero(), 0.0, 1.0);
  command.name = "blck";
  EXPECT_EQ(refused(command), Refusal::kUnknownShape);
  command = move({std::nan(""), 0.0, 0.0}, 0.0, 1.0);
  EXPECT_EQ(refused(command), Refusal::kNotFinite);
  command = move(Eigen::Vector3d::Zero(), 0.0, -1.0);
  EXPECT_EQ(refused(command), Refusal::kBadValue);
  command.duration = std::numeric_limits<double>::infinity();
  EXPECT_EQ(refused(command), Refusal::kNotFinite);
  // A scene without contact has no shapes.
  Simulation bare(Oscillator().scene(Scheme::kTrBdf2, 100.0));
  EXPECT_EQ(bare.apply(move(Eigen::Vector3d::Zero(), 0.0, 1.0)).refusal, Refusal::kUnknownShape);
}

}  // namespace
}  // namespace mass_spring
