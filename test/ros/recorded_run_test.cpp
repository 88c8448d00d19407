#include "ros/replay/recorded_run.h"

#include <gtest/gtest.h>
#include <std_msgs/String.h>

#include <filesystem>
#include <fstream>

#include "recording.h"

namespace mass_spring {
namespace {

/// A run of six steps with three commands, the first of the timeline.
Told shortRun() {
  Recording recording(kRecordedScene);
  recording.step(6);
  recording.apply(ForceCommand{"push", "sheet", {3}, {{0.0, 0.0, 0.1}}, 0.02});
  recording.apply(ForceCommand{"", "cable", {}, {{0.0, 0.1, 0.0}}, -1.0});
  return recording;
}

/// Why a run cannot be taken out of bags, when it is read to its end; "" = it can.
std::string refusal(const std::vector<std::string>& files, const std::string& node = "") {
  try {
    RecordedRun run(files, node);
    while (run.command() != nullptr) run.nextCommand();
  } catch (const BagError& error) {
    return error.what();
  }
  return "";
}

TEST(RecordedRun, TakesSceneCommandsAndStatesOutOfABag) {
  const Folder folder;
  const Told recording = shortRun();
  recording.write(folder / "run.bag");
  RecordedRun run({folder / "run.bag"}, "");
  EXPECT_EQ(run.node(), "/mass_spring");
  EXPECT_EQ(run.scene(), recording.scene);
  for (const auto& command : recording.commands) {
    ASSERT_NE(run.command(), nullptr);
    EXPECT_EQ(*run.command(), command);
    run.nextCommand();
  }
  EXPECT_EQ(run.command(), nullptr);
  for (const auto& state : recording.states) {
    ASSERT_NE(run.state(), nullptr);
    EXPECT_EQ(*run.state(), state);
    run.nextState();
  }
  EXPECT_EQ(run.state(), nullptr);
}

TEST(RecordedRun, PutsTogetherWhatWasSplit) {
  const Folder folder;
  Told recording = shortRun(), second = recording;
  second.commands.erase(second.commands.begin());
  recording.commands.resize(1);
  second.states.clear();
  recording.write(folder / "run_0.bag");
  second.write(folder / "run_1.bag");
  EXPECT_EQ(refusal({folder / "run_1.bag", folder / "run_0.bag"}), "");
  RecordedRun run({folder / "run_1.bag", folder / "run_0.bag"}, "");
  EXPECT_EQ(run.command()->number, 1u);
}

TEST(RecordedRun, NamesWhatIsMissing) {
  const Folder folder;
  Told gap = shortRun();
  gap.commands.erase(gap.commands.begin() + 1);
  gap.write(folder / "gap.bag");
  EXPECT_EQ(refusal({folder / "gap.bag"}),
            "after command 1 of /mass_spring comes 3: those in between were lost on the way to the "
            "recorder");
  Told anew = shortRun();
  anew.commands[2].number = 1;
  anew.write(folder / "anew.bag");
  EXPECT_TRUE(contains(refusal({folder / "anew.bag"}), "the node was started anew"));
}

TEST(RecordedRun, AsksForANodeWhereThereAreSeveral) {
  const Folder folder;
  const std::string file = folder / "two.bag";
  shortRun().write(file, "/left/mass_spring");
  shortRun().write(file, "/right");
  EXPECT_EQ(refusal({file}),
            "several nodes were recorded, choose one by --node: /left/mass_spring, /right");
  EXPECT_EQ(refusal({file}, "/middle"),
            "--node: got /middle, expected one of those recorded: /left/mass_spring, /right");
  EXPECT_EQ(refusal({file}, "/right"), "");
}

TEST(RecordedRun, RefusesBagsThatTellTooLittle) {
  const Folder folder;
  rosbag::Bag(folder / "empty.bag", rosbag::bagmode::Write).close();
  EXPECT_TRUE(contains(refusal({folder / "empty.bag"}), "no node has told of commands or states"));

  const Told recording = shortRun();
  rosbag::Bag bag(folder / "sceneless.bag", rosbag::bagmode::Write);
  bag.write("/sim/state", ros::Time(1, 0), recording.states[0]);
  bag.close();
  EXPECT_EQ(refusal({folder / "sceneless.bag"}),
            "there is no /sim/scene: record it, too; a recorder gets it at any time");

  bag.open(folder / "other.bag", rosbag::bagmode::Write);
  bag.write("/sim/state", ros::Time(1, 0), recording.states[0]);
  bag.write("/sim/scene", ros::Time(1, 0), recording.states[0]);
  bag.close();
  EXPECT_TRUE(contains(refusal({folder / "other.bag"}),
                       "/sim/scene is of the type mass_spring_sim/ParticleStates"));
}

TEST(RecordedRun, RefusesFilesThatAreNoWholeBags) {
  const Folder folder;
  EXPECT_TRUE(contains(refusal({folder / "none.bag"}), "none.bag cannot be read"));
  std::ofstream(folder / "text.bag") << "rate: 100\n";
  EXPECT_TRUE(contains(refusal({folder / "text.bag"}), "text.bag cannot be read"));

  const std::string whole = folder / "run.bag";
  shortRun().write(whole);
  const auto size = std::filesystem::file_size(whole);
  // From within the header to just before the end of the index.
  for (const double part : {0.001, 0.1, 0.5, 0.9, 0.999}) {
    const std::string cut = folder / "cut.bag";
    std::filesystem::copy_file(whole, cut, std::filesystem::copy_options::overwrite_existing);
    std::filesystem::resize_file(cut, static_cast<std::uintmax_t>(part * size));
    EXPECT_TRUE(contains(refusal({cut}), "rosbag reindex")) << part;
  }
}

}  // namespace
}  // namespace mass_spring
