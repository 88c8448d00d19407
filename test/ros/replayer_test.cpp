#include "ros/replay/replayer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mass_spring_sim/scene_reader.h"
#include "recording.h"

namespace mass_spring {
namespace {

PinCommand pin(PinCommand::Action action, const std::string& name) {
  PinCommand command;
  command.action = action;
  command.name = name;
  return command;
}

/// As the node has it done when the frame `hand` is heard of and moves on.
void leadByTf(Recording& recording) {
  PinCommand add = pin(PinCommand::Action::kAdd, "end");
  add.object = "cable";
  add.particles = {0};
  add.follow_frame = "hand";
  add.target.position = Eigen::Vector3d(-0.1, 1.0, 1.0);
  recording.apply(pin(PinCommand::Action::kRemove, "end"), "tf");
  recording.apply(add, "tf");
  recording.step(1);
  PinCommand move = pin(PinCommand::Action::kMove, "end");
  move.follow_frame = "hand";
  move.target.position = Eigen::Vector3d(-0.12, 1.0, 1.01);
  move.target.orientation = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY());
  recording.apply(move, "tf");
}

/// All that a timeline can say, over 40 steps.
void act(Recording& recording) {
  recording.step(2);
  recording.apply(ForceCommand{"push", "sheet", {19, 18}, {{0.3, -0.2, 0.1}}, 0.055});
  recording.apply(ForceCommand{"", "cable", {}, {{0.0, 0.1, 0.0}}, -1.0});
  PinCommand grab = pin(PinCommand::Action::kAdd, "grab");
  grab.object = "sheet";
  grab.point = Eigen::Vector3d(0.2, -0.15, 1.0);
  grab.radius = 0.15;
  grab.here = true;
  recording.apply(grab);
  leadByTf(recording);
  recording.step(7);  // beyond the force of the timeline
  PinCommand move = pin(PinCommand::Action::kMove, "grab");
  move.target.position = Eigen::Vector3d(0.2, -0.1, 1.1);
  move.target.orientation = Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized());
  recording.apply(move);
  recording.apply(ShapeCommand{"ball", {{0.05, 0.0, 0.9}, move.target.orientation}, 0.1});
  recording.step(10);
  recording.apply(ClearCommand{ClearCommand::What::kForces});
  recording.step(5);
  recording.apply(ClearCommand{ClearCommand::What::kPins});
  recording.step(15);
}

Comparison compared(const Told& recording, std::string* timeline = nullptr) {
  const Folder folder;
  recording.write(folder / "run.bag");
  RecordedRun run({folder / "run.bag"}, "");
  Replayer replayer(run);
  replayer.run();
  if (timeline != nullptr) *timeline = replayer.timeline().toYaml();
  return replayer.comparison();
}

std::string refusal(const Told& recording) {
  try {
    std::string timeline;
    compared(recording, &timeline);
  } catch (const BagError& error) {
    return error.what();
  }
  return "";
}

std::string withScheme(const std::string& scheme) {
  std::string scene = kRecordedScene;
  return scene.replace(scene.find("implicit_euler"), 14, scheme);
}

class ReplayerOnClock : public testing::TestWithParam<Recording::Stamps> {};

TEST_P(ReplayerOnClock, DoesEveryKindOfCommandAgain) {
  Recording recording(kRecordedScene, GetParam());
  recording.reset();  // before any step
  act(recording);
  recording.reset();
  recording.reset();
  recording.step(6);
  recording.reload(withScheme("tr_bdf2"));
  recording.step(5);
  recording.setState(recording.simulation().state().positions * 1.01,
                     recording.simulation().state().velocities * 0.5);
  recording.step(5);
  std::string heavier = kRecordedScene;
  recording.reload(heavier.replace(heavier.find("mass: 0.2"), 9, "mass: 0.3"));
  act(recording);
  const Comparison comparison = compared(recording);
  EXPECT_TRUE(comparison.same());
  EXPECT_EQ(comparison.refused, std::vector<std::string>());
  EXPECT_EQ(comparison.states, recording.states.size());
  EXPECT_EQ(comparison.commands, recording.commands.size());
  EXPECT_EQ(comparison.restarts, 4u);
}

TEST_P(ReplayerOnClock, NeedsNotEveryState) {
  Recording recording(kRecordedScene, GetParam());
  act(recording);
  recording.reset();
  act(recording);
  auto all = std::move(recording.states);
  recording.states.clear();
  for (const auto& state : all) {
    if (state.step % 7 == 0) recording.states.push_back(state);
  }
  EXPECT_TRUE(compared(recording).same());
  EXPECT_EQ(compared(recording).states, recording.states.size());
  recording.states.clear();
  EXPECT_TRUE(compared(recording).same());
  EXPECT_EQ(compared(recording).states, 0u);
}

TEST_P(ReplayerOnClock, GoesBackWhereAStepFailed) {
  Recording recording(kRecordedScene, GetParam());
  recording.step(10);
  recording.reload(withScheme("rk4"));  // far beyond its largest stable step
  // Steps that are gone back over use it up, too.
  recording.apply(ForceCommand{"", "sheet", {3}, {{0.0, 0.0, 0.1}}, 0.4});
  for (int time = 0; time < 2; ++time) {
    recording.step(1000);
    ASSERT_EQ(recording.commands.back().kind, mass_spring_sim::AppliedCommand::FAILED_STEP);
    ASSERT_GT(recording.commands.back().step, recording.simulation().state().step + 2);
  }
  recording.reload(kRecordedScene);
  recording.step(40);
  EXPECT_LT(recording.states.back().step, 60u);
  const Comparison comparison = compared(recording);
  EXPECT_TRUE(comparison.same());
  EXPECT_EQ(comparison.refused, std::vector<std::string>());
  EXPECT_EQ(comparison.states, recording.states.size());
  EXPECT_EQ(comparison.commands, recording.commands.size());
}

INSTANTIATE_TEST_SUITE_P(BothClocks, ReplayerOnClock,
                         testing::Values(Recording::Stamps::kWall, Recording::Stamps::kSimulated));

TEST(Replayer, FindsTheLastBit) {
  Recording recording(kRecordedScene);
  act(recording);
  double& x = recording.states[20].positions[3 * (7 + 4) + 1];  // the cable's seven come first
  x = std::nextafter(x, 10.0);
  recording.states[30].velocities[0] += 1e-3;
  const Comparison comparison = compared(recording);
  EXPECT_EQ(comparison.differing_states, 2u);
  ASSERT_TRUE(comparison.first && comparison.largest);
  EXPECT_EQ(comparison.first->step, 21u);
  EXPECT_EQ(comparison.first->object, "sheet");
  EXPECT_EQ(comparison.first->particle, 4u);
  EXPECT_FALSE(comparison.first->velocity);
  EXPECT_EQ(comparison.first->recorded.y(), x);
  EXPECT_EQ(comparison.first->simulated.y(), std::nextafter(x, -10.0));
  EXPECT_EQ(comparison.largest->step, 21u);  // of positions
}

TEST(Replayer, FindsThatTheRunDiffersWithoutACommand) {
  Recording recording(kRecordedScene);
  act(recording);
  recording.commands.erase(recording.commands.begin());
  for (auto& command : recording.commands) --command.number;
  for (auto& state : recording.states) state.commands -= std::min<std::uint64_t>(state.commands, 1);
  const Comparison comparison = compared(recording);
  ASSERT_TRUE(comparison.first);
  EXPECT_EQ(comparison.first->step, 3u);
  EXPECT_EQ(comparison.first->object, "sheet");
}

TEST(Replayer, TellsABagThatLacksCommandsFromARunThatDiffers) {
  Recording recording(kRecordedScene);
  act(recording);
  const std::uint64_t last = recording.commands.size();
  // In the middle, the numbers of those around it tell.
  Told gap = recording;
  gap.commands.erase(gap.commands.begin() + 4);
  EXPECT_EQ(refusal(gap),
            "after command 4 of /mass_spring comes 6: those in between were lost on the way to the "
            "recorder");
  // At the end, the states tell. The last command came 15 steps before the end, the one before
  // 5 steps earlier.
  Told end = recording;
  end.commands.pop_back();
  const std::string came = " of /mass_spring, which came before its state of step ";
  EXPECT_TRUE(contains(refusal(end), "the bag lacks the commands " + std::to_string(last) + " to " +
                                         std::to_string(last) + came + "26"))
      << refusal(end);
  EXPECT_TRUE(contains(refusal(end), "Of the 25 states before, 0 differ")) << refusal(end);
  end.commands.pop_back();
  EXPECT_TRUE(contains(refusal(end), "the bag lacks the commands " + std::to_string(last - 1) +
                                         " to " + std::to_string(last - 1) + came + "21"))
      << refusal(end);
  // The states end before what is missing.
  end.states.resize(20);
  EXPECT_TRUE(compared(end).same());
  // No command at all.
  end.commands.clear();
  EXPECT_TRUE(contains(refusal(end), "the bag lacks the commands 1 to 5" + came + "3"))
      << refusal(end);
}

TEST(Replayer, TakesTheSameStateTwice) {
  Recording recording(kRecordedScene, Recording::Stamps::kSimulated);
  recording.step(4);
  recording.tellState();
  recording.setState(recording.simulation().state().positions * 1.01,
                     recording.simulation().state().velocities * 0.5);
  recording.tellState();  // as the node does while it is paused
  recording.step(2);
  EXPECT_TRUE(compared(recording).same());
  EXPECT_EQ(compared(recording).states, 8u);
}

TEST(Replayer, FindsThatTheTimelineDidOtherwise) {
  Recording recording(kRecordedScene);
  act(recording);
  for (auto& command : recording.commands) {
    if (command.sender == "timeline") command.force.duration = 0.06;
  }
  const Comparison comparison = compared(recording);
  EXPECT_EQ(comparison.differing_states, 0u);
  EXPECT_EQ(
      comparison.refused,
      std::vector<std::string>{"before step 6 the scene's timeline gave other commands than now"});
}

TEST(Replayer, FindsThatAStepThatFailedDoesNotNow) {
  Recording recording(kRecordedScene);
  recording.step(4);
  mass_spring_sim::AppliedCommand failed;
  failed.kind = mass_spring_sim::AppliedCommand::FAILED_STEP;
  failed.header.stamp = recording.states.back().header.stamp;
  failed.number = 1;
  failed.step = 5;
  recording.commands.push_back(failed);
  EXPECT_EQ(compared(recording).refused,
            std::vector<std::string>{"step 5 failed, and does not now"});
}

TEST(Replayer, FindsThatACommandIsRefusedNow) {
  Recording recording(kRecordedScene);
  act(recording);
  recording.commands[2].pin.name = "grip";
  const Comparison comparison = compared(recording);
  ASSERT_EQ(comparison.refused.size(), 1u);
  EXPECT_TRUE(contains(comparison.refused[0],
                       "(pin of /somebody, before step 11) is refused now: "
                       "name: got 'grab'"));
}

TEST(Replayer, BeginsAfterCommandsOfTheTimeline) {
  Recording recording(kRecordedScene);
  recording.step(10);
  recording.apply(ForceCommand{"", "sheet", {3}, {{0.0, 0.0, 0.1}}, 0.02});
  recording.step(5);
  recording.commands.erase(recording.commands.begin());
  recording.states.erase(recording.states.begin(), recording.states.begin() + 8);
  const Comparison comparison = compared(recording);
  EXPECT_TRUE(comparison.same());
  EXPECT_EQ(comparison.states, 7u);
}

TEST(Replayer, BeginsWithAResetWhereCommandsWereMissed) {
  Recording recording(kRecordedScene);
  recording.apply(ForceCommand{"", "sheet", {3}, {{0.0, 0.0, 0.1}}, -1.0});
  recording.step(3);
  recording.apply(ForceCommand{"", "sheet", {2}, {{0.0, 0.0, 0.1}}, -1.0});
  recording.step(1);
  Told late = recording;
  late.commands.erase(late.commands.begin());
  EXPECT_EQ(refusal(late),
            "the recording began late: 1 commands came before command 2 (force of /somebody, "
            "before step 4), the first in it. Begin it before them, or with a ~reset");
  recording.reset();
  recording.step(3);
  recording.commands.erase(recording.commands.begin(), recording.commands.begin() + 2);
  const Comparison comparison = compared(recording);
  EXPECT_TRUE(comparison.same());
  EXPECT_EQ(comparison.missed_commands, 2u);
  EXPECT_EQ(comparison.states, 4u);
}

TEST(Replayer, RefusesARunThatFallsBack) {
  Recording recording(kRecordedScene);
  recording.step(4);
  recording.reset();
  recording.step(3);
  recording.commands.clear();
  EXPECT_EQ(refusal(recording),
            "the run falls back from step 4 to step 0, but no reset was recorded");
}

TEST(RecordedTimeline, DoesTheSameRun) {
  Recording recording(kRecordedScene);
  recording.step(20);
  recording.reset();
  act(recording);
  std::string timeline;
  EXPECT_TRUE(compared(recording, &timeline).same());
  Simulation simulation(readScene(readYamlText(timeline, "timeline"), ""));
  EXPECT_EQ(simulation.scene().timeline.size(), recording.commands.size() - 2);  // - force, reset
  const std::size_t start = recording.states.size() - 40 - 1;
  for (std::size_t k = start; k < recording.states.size(); ++k) {
    const State& state = simulation.state();
    ASSERT_EQ(state.step, recording.states[k].step);
    ASSERT_EQ(std::vector<double>(state.positions.data(),
                                  state.positions.data() + state.positions.size()),
              recording.states[k].positions);
    simulation.step();
  }
}

TEST(RecordedTimeline, SaysWhatATimelineCannotSay) {
  Recording put(kRecordedScene);
  put.step(4);
  put.setState(put.simulation().state().positions, put.simulation().state().velocities);
  EXPECT_EQ(refusal(put), "a timeline cannot say ~set_state before step 5");
  put.reset();  // and so behind us
  EXPECT_EQ(refusal(put), "");
  put.step(7);
  put.reload(withScheme("tr_bdf2"));
  EXPECT_EQ(refusal(put),
            "a timeline cannot say the ~reload that the run went on with before step 8");
}

TEST(RecordedTimeline, EndsWhereAStepFails) {
  Recording recording(withScheme("rk4"));
  recording.step(1000);
  const std::uint64_t failed = recording.commands.back().step;
  EXPECT_EQ(refusal(recording), "");
  recording.step(1);
  EXPECT_EQ(refusal(recording), "a timeline cannot say how the run went on after step " +
                                    std::to_string(failed) + " had failed");
  recording.reset();  // and so behind us
  recording.step(1);
  EXPECT_EQ(refusal(recording), "");
}

TEST(RecordedTimeline, CommandsAreDueAtTheirSteps) {
  Scene scene = readScene(readYamlText(kRecordedScene, "scene"), "");
  for (const double rate : {1.0, 7.0, 60.0, 100.0, 333.3, 997.0, 1e4 / 3.0, 10000.0}) {
    scene.rate = rate;
    RecordedTimeline timeline;
    timeline.startOver(scene);
    std::vector<std::uint64_t> steps;
    for (std::uint64_t step = 1; step < std::uint64_t{1} << 40; step += step / 50 + 1) {
      steps.push_back(step);
      timeline.add(step, ClearCommand{});
    }
    const Scene again = readScene(readYamlText(timeline.toYaml(), "timeline"), "");
    for (std::size_t k = 0; k < steps.size(); ++k) {
      // As Simulation::timelineDue has it.
      const auto due = [&](double done) { return again.timeline[k].time * rate <= done + 1e-9; };
      const auto done = static_cast<double>(steps[k] - 1);
      EXPECT_TRUE(due(done)) << rate << ' ' << steps[k];
      EXPECT_FALSE(due(done - 1.0)) << rate << ' ' << steps[k];
    }
  }
}

}  // namespace
}  // namespace mass_spring
