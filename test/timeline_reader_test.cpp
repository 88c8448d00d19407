#include <gtest/gtest.h>

#include "scene_text.h"

namespace mass_spring {
namespace {

using Lines = std::vector<std::string>;

const char* const kOneObject =
    "objects: {dot: {type: particles, positions: [[0, 0, 0], [1, 0, 0]], masses: 1}}\n";

/// The commands of a timeline over one object of two particles.
std::vector<TimedCommand> commandsOf(const std::string& timeline) {
  return readScene(readYamlText(kOneObject + timeline, "scene"), "").timeline;
}

Lines problemsOfTimeline(const std::string& timeline) { return problemsOf(kOneObject + timeline); }

TEST(TimelineReader, ReadsForces) {
  const auto timeline = commandsOf(
      "timeline: [{time: 0.5, force: {object: dot, particles: [1], forces: [[1, 2, 3]],"
      " duration: -1, id: push}}, {time: 0.5, force: {forces: [[0, 0, 1], [0, 0, 2]]}}]");
  ASSERT_EQ(timeline.size(), 2u);
  EXPECT_EQ(timeline[0].time, 0.5);
  const auto& first = std::get<ForceCommand>(timeline[0].command);
  EXPECT_EQ(first.object, "dot");
  EXPECT_EQ(first.particles, std::vector<std::uint32_t>{1});
  EXPECT_EQ(first.forces.at(0), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(first.duration, -1.0);
  EXPECT_EQ(first.id, "push");
  const auto& second = std::get<ForceCommand>(timeline[1].command);
  EXPECT_EQ(second.object, "dot");  // the only one there is
  EXPECT_TRUE(second.particles.empty());
  EXPECT_EQ(second.forces.size(), 2u);
  EXPECT_EQ(second.duration, 0.0);
}

TEST(TimelineReader, ReadsPins) {
  const auto timeline = commandsOf(
      "timeline:\n"
      "  - {time: 0, pin: {action: add, name: a, particles: [0]}}\n"
      "  - {time: 1, pin: {action: add, name: b, point: [1, 0, 0], radius: 0.5,"
      " target: [1, 2, 3]}}\n"
      "  - {time: 2, pin: {action: move, name: a, target: [4, 5, 6], orientation: [0, 0, "
      "deg(90)]}}\n"
      "  - {time: 3, pin: {action: move, name: a, target: [0, 0, 0], orientation: [0, 0.6, 0, "
      "0.8]}}\n"
      "  - {time: 4, pin: {action: remove, name: a}}\n");
  ASSERT_EQ(timeline.size(), 5u);
  const auto pin = [&](int i) { return std::get<PinCommand>(timeline[i].command); };
  EXPECT_EQ(pin(0).action, PinCommand::Action::kAdd);
  EXPECT_EQ(pin(0).name, "a");
  EXPECT_EQ(pin(0).object, "dot");
  EXPECT_EQ(pin(0).particles, std::vector<std::uint32_t>{0});
  EXPECT_TRUE(pin(0).here);
  EXPECT_TRUE(pin(1).particles.empty());
  EXPECT_EQ(pin(1).point, Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(pin(1).radius, 0.5);
  EXPECT_FALSE(pin(1).here);
  EXPECT_EQ(pin(1).target.position, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(pin(2).action, PinCommand::Action::kMove);
  // A quarter turn about z takes x to y, but for the rounding of pi.
  EXPECT_NEAR((pin(2).target.orientation * Eigen::Vector3d::UnitX()).y(), 1.0, 1e-15);
  EXPECT_EQ(pin(3).target.orientation.coeffs(), Eigen::Vector4d(0, 0.6, 0, 0.8));
  EXPECT_EQ(pin(4).action, PinCommand::Action::kRemove);
}

TEST(TimelineReader, ReadsWhatIsCleared) {
  const auto timeline = commandsOf("timeline: [{time: 0, clear: forces}, {time: 1, clear: pins}]");
  ASSERT_EQ(timeline.size(), 2u);
  EXPECT_EQ(std::get<ClearCommand>(timeline[0].command).what, ClearCommand::What::kForces);
  EXPECT_EQ(std::get<ClearCommand>(timeline[1].command).what, ClearCommand::What::kPins);
}

TEST(TimelineReader, SortsByTimeAndKeepsTheOrderOfEqualTimes) {
  const auto timeline = commandsOf(
      "timeline: [{time: 2, force: {id: c, forces: [[0, 0, 0]]}},"
      " {time: 1, force: {id: a, forces: [[0, 0, 0]]}},"
      " {time: 1, force: {id: b, forces: [[0, 0, 0]]}}]");
  std::string ids;
  for (const auto& timed : timeline) ids += std::get<ForceCommand>(timed.command).id;
  EXPECT_EQ(ids, "abc");
}

struct BadTimeline {
  const char *entry, *problem;
};

TEST(TimelineReader, RefusesEachBadCommandByName) {
  const std::vector<BadTimeline> rows = {
      {"{time: 0}", ": got no command, expected just one of force, pin, shape and clear"},
      {"{time: 0, force: {forces: [[0, 0, 0]]}, pin: {action: remove, name: a}}",
       ": got several commands, expected just one of force, pin, shape and clear"},
      {"{time: 0, shape: {name: ball, target: [0, 0, 0]}}",
       ".shape.name: got 'ball', expected a shape of effects.contact, of which there is none"},
      {"{force: {forces: [[0, 0, 0]]}}", ".time: got nothing, expected a number >= 0 (s)"},
      {"{time: -1, force: {forces: [[0, 0, 0]]}}", ".time: got -1, expected a number >= 0 (s)"},
      {"{time: 0, force: {object: dog, forces: [[0, 0, 0]]}}",
       ".force.object: got 'dog', expected one of dot (did you mean 'dot'?)"},
      {"{time: 0, force: {particles: [2], forces: [[0, 0, 0]]}}",
       ".force.particles[0]: got 2, expected an integer in [0, 1]"},
      {"{time: 0, force: {particles: [1, 1], forces: [[0, 0, 0]]}}",
       ".force.particles[1]: got 1 again, expected each particle once"},
      {"{time: 0, force: {particles: [0]}}",
       ".force.forces: got nothing, expected a list of forces, each a list of 3 finite numbers "
       "(N)"},
      {"{time: 0, force: {forces: []}}",
       ".force.forces: got an empty list, expected a list of 1 force, or of 2, one for each "
       "particle"},
      {"{time: 0, force: {particles: [0], forces: [[0, 0, 0], [0, 0, 0]]}}",
       ".force.forces: got a list of 2, expected a list of 1 force, or of 1, one for each "
       "particle"},
      {"{time: 0, force: {forces: [0, 0, 1]}}",
       ".force.forces: got a list of 3, expected a list of 1 force, or of 2, one for each "
       "particle"},
      {"{time: 0, force: {forces: [[0, 0, 2e6]]}}",
       ".force.forces[0]: got a force of 2000000.0 N, expected at most 1000000.0 N "
       "(limits.max_force)"},
      {"{time: 0, force: {forces: [[0, 0, 1e308], [0, 0, .inf]]}}",
       ".force.forces: expected two problems"},
      {"{time: 0, force: {forces: [[0, 0, 0]], duration: .inf}}",
       ".force.duration: got inf, expected a finite number (s)"},
      {"{time: 0, pin: {action: ad, name: a}}",
       ".pin.action: got 'ad', expected one of add, move, remove (did you mean 'add'?)"},
      {"{time: 0, pin: {action: remove, name: '1'}}",
       ".pin.name: got '1', expected a name of letters, digits and _ that begins with a letter"},
      {"{time: 0, pin: {action: add, name: a}}",
       ".pin.particles: got nothing, expected a list of particle indices, or point instead"},
      {"{time: 0, pin: {action: add, name: a, particles: []}}",
       ".pin.particles: got an empty list, expected a list of particle indices, or point instead"},
      {"{time: 0, pin: {action: add, name: a, particles: [0], point: [0, 0, 0]}}",
       ".pin.point: got particles as well, expected either particles or point"},
      {"{time: 0, pin: {action: add, name: a, particles: [0], radius: 1}}",
       ".pin.radius: got a radius without a point, expected point as well"},
      {"{time: 0, pin: {action: add, name: a, point: [0, 0, 0], radius: -1}}",
       ".pin.radius: got -1, expected a number >= 0 (m)"},
      {"{time: 0, pin: {action: add, name: a, particles: [0], orientation: [0, 0, 0]}}",
       ".pin.orientation: got an orientation without a target, expected target as well"},
      {"{time: 0, pin: {action: add, name: a, particles: [0], target: [0, 0, 0],"
       " orientation: [0, 0, 0, 2]}}",
       ".pin.orientation: got another length, expected roll pitch yaw (rad), or a unit quaternion "
       "x y z w"},
      {"{time: 0, pin: {action: add, name: a, particles: [9]}}",
       ".pin.particles[0]: got 9, expected an integer in [0, 1]"},
      {"{time: 0, clear: pin}",
       ".clear: got 'pin', expected one of forces, pins (did you mean 'pins'?)"},
      {"{time: 0, pin: {action: move, name: a}}",
       ".pin.target: got nothing, expected a list of 3 finite numbers (m)"},
  };
  for (const BadTimeline& row : rows) {
    const Lines problems = problemsOfTimeline(std::string("timeline: [") + row.entry + "]");
    if (std::string(row.problem) == ".force.forces: expected two problems") {
      EXPECT_EQ(problems.size(), 2u) << row.entry;
      continue;
    }
    EXPECT_EQ(problems, Lines{"timeline[0]" + std::string(row.problem)}) << row.entry;
  }
}

TEST(TimelineReader, RefusesWhatIsNoListOfMaps) {
  EXPECT_EQ(problemsOfTimeline("timeline: {}"),
            Lines{"timeline: got an empty map, expected a list of commands"});
  EXPECT_EQ(problemsOfTimeline("timeline: [1]").at(0),
            "timeline[0]: got 1, expected a map with time and one of force, pin, shape and clear");
}

TEST(TimelineReader, ObjectMustBeNamedWhereThereAreSeveral) {
  EXPECT_EQ(problemsOf(sceneWith("timeline[0].force.object", kRemoved)),
            Lines{"timeline[0].force.object: got nothing, expected one of block, cable, net, "
                  "sheet"});
}

TEST(TimelineReader, WalksThroughThePins) {
  const std::string pins = "pins: {held: {object: dot, particles: [0]}}\n";
  const auto problems = [&](const std::string& timeline) {
    return problemsOfTimeline(pins + "timeline:\n" + timeline);
  };
  EXPECT_EQ(problems("  - {time: 0, pin: {action: remove, name: other}}\n"),
            Lines{"timeline[0].pin.name: got 'other', expected a pin that exists at that time "
                  "(held)"});
  EXPECT_EQ(
      problems("  - {time: 0, pin: {action: add, name: held, particles: [1]}}\n"),
      Lines{"timeline[0].pin.name: got 'held', expected a name that no pin has at that time"});
  EXPECT_EQ(
      problems("  - {time: 0, pin: {action: add, name: more, particles: [1, 0]}}\n"),
      Lines{"timeline[0].pin.particles[1]: got 0, expected a particle that no other pin holds "
            "('held' holds it)"});
  // In order of time, not of the file.
  EXPECT_EQ(problems("  - {time: 2, pin: {action: add, name: more, particles: [0]}}\n"
                     "  - {time: 1, pin: {action: remove, name: held}}\n"
                     "  - {time: 3, pin: {action: move, name: more, target: [0, 0, 0]}}\n"),
            Lines());
  EXPECT_EQ(
      problems("  - {time: 1, pin: {action: remove, name: held}}\n"
               "  - {time: 2, pin: {action: move, name: held, target: [0, 0, 0]}}\n"),
      Lines{"timeline[1].pin.name: got 'held', expected a pin that exists at that time (there "
            "is none)"});
  // What is cleared can be made and held again.
  EXPECT_EQ(problems("  - {time: 1, clear: pins}\n"
                     "  - {time: 2, pin: {action: add, name: held, particles: [0]}}\n"),
            Lines());
  EXPECT_EQ(problems("  - {time: 1, clear: forces}\n"
                     "  - {time: 2, pin: {action: add, name: more, particles: [0]}}\n")
                .size(),
            1u);
}

}  // namespace
}  // namespace mass_spring
