#include "ros/conversions.h"

#include <gtest/gtest.h>
#include <tf2/exceptions.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <vector>

namespace mass_spring {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Sums of a few numbers of size 1.
constexpr double kRounding = 1e-15;

/// "tool" stands at (1, 2, 3), turned by 90 degrees about z; others are not known.
Eigen::Isometry3d lookup(const std::string& frame_id) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  if (frame_id.empty()) return pose;
  if (frame_id != "tool") throw tf2::LookupException("no frame " + frame_id);
  pose.translate(Eigen::Vector3d(1.0, 2.0, 3.0));
  pose.rotate(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()));
  return pose;
}

mass_spring_sim::ForceCommand forceMessage() {
  mass_spring_sim::ForceCommand message;
  message.id = "push";
  message.object = "sheet";
  message.particles = {4, 2};
  message.forces.resize(2);
  message.forces[0].x = 1.0;
  message.forces[1].z = -2.0;
  message.duration = -1.0;
  return message;
}

mass_spring_sim::PinCommand pinMessage() {
  mass_spring_sim::PinCommand message;
  message.name = "grab";
  message.object = "sheet";
  message.particles = {7};
  message.target.position.x = 1.0;
  return message;
}

TEST(ForceConversion, TurnsForcesAndLeavesTheRest) {
  mass_spring_sim::ForceCommand message = forceMessage();
  message.header.frame_id = "tool";
  ForceCommand command;
  ASSERT_TRUE(toCommand(message, lookup, command).accepted());
  EXPECT_EQ(command.id, "push");
  EXPECT_EQ(command.object, "sheet");
  EXPECT_EQ(command.particles, (std::vector<std::uint32_t>{4, 2}));
  EXPECT_EQ(command.duration, -1.0);
  ASSERT_EQ(command.forces.size(), 2u);
  EXPECT_LE((command.forces[0] - Eigen::Vector3d(0.0, 1.0, 0.0)).norm(), kRounding);
  EXPECT_LE((command.forces[1] - Eigen::Vector3d(0.0, 0.0, -2.0)).norm(), kRounding);
}

TEST(ForceConversion, RefusesWhatIsNotFiniteAndUnknownFrames) {
  using Message = mass_spring_sim::ForceCommand;
  const std::vector<std::pair<Refusal, std::function<void(Message&)>>> cases = {
      {Refusal::kNotFinite, [](Message& m) { m.forces[1].y = kNaN; }},
      {Refusal::kNotFinite, [](Message& m) { m.forces[0].x = -kInfinity; }},
      {Refusal::kNotFinite, [](Message& m) { m.duration = kInfinity; }},
      {Refusal::kBadFrame, [](Message& m) { m.header.frame_id = "nowhere"; }},
  };
  for (const auto& [refusal, spoil] : cases) {
    Message message = forceMessage();
    spoil(message);
    ForceCommand command;
    const CommandResult result = toCommand(message, lookup, command);
    EXPECT_EQ(result.refusal, refusal) << result.message;
    EXPECT_NE(result.message, "");
  }
}

TEST(PinConversion, TakesPointAndTargetToTheScene) {
  mass_spring_sim::PinCommand message = pinMessage();
  message.header.frame_id = "tool";
  message.point.y = 1.0;
  message.radius = 0.25;
  PinCommand command;
  ASSERT_TRUE(toCommand(message, lookup, command).accepted());
  EXPECT_EQ(command.action, PinCommand::Action::kAdd);
  EXPECT_EQ(command.name, "grab");
  EXPECT_EQ(command.object, "sheet");
  EXPECT_EQ(command.particles, std::vector<std::uint32_t>{7});
  EXPECT_LE((command.point - Eigen::Vector3d(0.0, 2.0, 3.0)).norm(), kRounding);
  EXPECT_EQ(command.radius, 0.25);
  EXPECT_LE((command.target.position - Eigen::Vector3d(1.0, 3.0, 3.0)).norm(), kRounding);
  const Eigen::Quaterniond quarter_turn(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()));
  EXPECT_LE(command.target.orientation.angularDistance(quarter_turn), kRounding);
}

TEST(PinConversion, NormalizesQuaternionsWithinATolerance) {
  for (const double length : {0.0, 0.9991, 1.0, 1.0009}) {
    mass_spring_sim::PinCommand message = pinMessage();
    message.target.orientation.x = length;
    PinCommand command;
    ASSERT_TRUE(toCommand(message, lookup, command).accepted()) << length;
    const Eigen::Quaterniond expected =
        length == 0.0 ? Eigen::Quaterniond::Identity() : Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0);
    EXPECT_LE((command.target.orientation.coeffs() - expected.coeffs()).norm(), kRounding);
  }
}

TEST(PinConversion, RefusesWhatItCannotNameOrSee) {
  using Message = mass_spring_sim::PinCommand;
  const std::vector<std::pair<Refusal, std::function<void(Message&)>>> cases = {
      {Refusal::kNotFinite, [](Message& m) { m.point.x = kNaN; }},
      {Refusal::kNotFinite, [](Message& m) { m.radius = kInfinity; }},
      {Refusal::kNotFinite, [](Message& m) { m.target.position.z = -kInfinity; }},
      {Refusal::kNotFinite, [](Message& m) { m.target.orientation.w = kNaN; }},
      {Refusal::kBadValue, [](Message& m) { m.action = 3; }},
      {Refusal::kBadValue, [](Message& m) { m.target.orientation.w = 0.99; }},
      {Refusal::kBadValue, [](Message& m) { m.target.orientation.w = 1.01; }},
      {Refusal::kBadValue, [](Message& m) { m.target.orientation.w = 1e200; }},
      {Refusal::kBadFrame, [](Message& m) { m.follow_frame = "nowhere"; }},
      {Refusal::kBadValue,
       [](Message& m) {
         m.action = Message::MOVE;
         m.follow_frame = "tool";
       }},
      {Refusal::kBadFrame, [](Message& m) { m.header.frame_id = "nowhere"; }},
  };
  for (const auto& [refusal, spoil] : cases) {
    Message message = pinMessage();
    spoil(message);
    PinCommand command;
    const CommandResult result = toCommand(message, lookup, command);
    EXPECT_EQ(result.refusal, refusal) << result.message;
    EXPECT_NE(result.message, "");
  }
}

TEST(PinConversion, LetsGoWithoutAFrame) {
  mass_spring_sim::PinCommand message = pinMessage();
  message.action = mass_spring_sim::PinCommand::REMOVE;
  message.header.frame_id = "nowhere";
  PinCommand command;
  EXPECT_TRUE(toCommand(message, lookup, command).accepted());
  EXPECT_EQ(command.action, PinCommand::Action::kRemove);
}

TEST(AppliedConversion, ReadsBackAsTheSameCommand) {
  ForceCommand force;
  ASSERT_TRUE(toCommand(forceMessage(), lookup, force).accepted());
  const mass_spring_sim::AppliedCommand applied_force = toMessage(Command(force));
  EXPECT_EQ(applied_force.kind, mass_spring_sim::AppliedCommand::FORCE);
  EXPECT_EQ(applied_force.force, forceMessage());

  mass_spring_sim::PinCommand message = pinMessage();
  message.target.orientation.w = 1.0;
  message.here = true;
  message.follow_frame = "tool";
  PinCommand pin;
  ASSERT_TRUE(toCommand(message, lookup, pin).accepted());
  const mass_spring_sim::AppliedCommand applied_pin = toMessage(Command(pin));
  EXPECT_EQ(applied_pin.kind, mass_spring_sim::AppliedCommand::PIN);
  EXPECT_EQ(applied_pin.pin, message);
}

TEST(AppliedConversion, ComesBackBitForBit) {
  // Neither of unit length nor of numbers that a decimal or a product would keep.
  const Pose pose{{0.1, -1.0 / 3.0, 1e-300}, {0.6000000000000001, -0.0, 0.8, 1e-17}};
  PinCommand pin;
  pin.action = PinCommand::Action::kMove;
  pin.name = "grab";
  pin.object = "sheet";
  pin.particles = {7, 1};
  pin.point = Eigen::Vector3d(0.1, 0.2, 0.3);
  pin.radius = 1e-5;
  pin.target = pose;
  pin.here = true;
  pin.follow_frame = "tool";
  const Command commands[] = {
      ForceCommand{"push", "sheet", {4, 2}, {{1.0 / 3.0, -0.0, 5e-324}, {1, 2, 3}}, -0.1}, pin,
      ShapeCommand{"ball", pose, 0.1}, ClearCommand{ClearCommand::What::kForces},
      ClearCommand{ClearCommand::What::kPins}};
  for (const Command& command : commands) {
    const mass_spring_sim::AppliedCommand message = toMessage(command);
    EXPECT_EQ(message.kind, command.index() + (command.index() == 3 && message.kind == 4));
    const Command again = toCommand(message);
    ASSERT_EQ(again.index(), command.index());
    EXPECT_EQ(toMessage(again), message);
    if (const auto* shape = std::get_if<ShapeCommand>(&again)) {
      // Also the signs of zeros.
      EXPECT_EQ(std::memcmp(&shape->target.position, &pose.position, sizeof pose.position), 0);
      EXPECT_EQ(std::memcmp(&shape->target.orientation, &pose.orientation, sizeof pose.orientation),
                0);
    }
  }
}

}  // namespace
}  // namespace mass_spring
