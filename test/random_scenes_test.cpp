#include "random_scenes.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "mass_spring_sim/scene_reader.h"
#include "mass_spring_sim/simulation.h"
#include "process.h"
#include "sanitizers.h"
#include "scene_text.h"

// Two hundred random scenes, each a test of its own. MASS_SPRING_RANDOM_SCENES=10000 in the
// environment makes it as many, MASS_SPRING_RANDOM_SEED=1000 begins with another seed.
namespace mass_spring {
namespace {

constexpr int kSteps = 20;

std::uint32_t fromEnvironment(const char* variable, std::uint32_t otherwise) {
  const char* text = std::getenv(variable);
  return text ? static_cast<std::uint32_t>(std::strtoul(text, nullptr, 10)) : otherwise;
}

class RandomScene : public testing::Test {
 public:
  explicit RandomScene(std::uint32_t seed) : seed_(seed) {}
  void TestBody() override {
    const Scene scene = randomScene(seed_);
    const auto violation = findViolation(scene, kSteps);
    EXPECT_FALSE(violation) << reproduction(seed_, scene, kSteps, *violation, testing::TempDir());
  }

 private:
  std::uint32_t seed_;
};

const bool random_scenes_registered = [] {
  const std::uint32_t first = fromEnvironment("MASS_SPRING_RANDOM_SEED", 1);
  const std::uint32_t count =
      fromEnvironment("MASS_SPRING_RANDOM_SCENES", underSanitizers() ? 50 : 200);
  for (std::uint32_t seed = first; seed < first + count; ++seed) {
    testing::RegisterTest("RandomScenes", ("seed_" + std::to_string(seed)).c_str(), nullptr,
                          nullptr, __FILE__, __LINE__,
                          [seed]() -> testing::Test* { return new RandomScene(seed); });
  }
  return true;
}();

// A pin jumps, and strong dampers take away most of the work that it does. The step after that may
// not give it back.
TEST(RandomSceneFiles, LossesOfAJumpDoNotPayForALaterGain) {
  const auto violation = findViolation(randomScene(5627), kSteps);
  EXPECT_FALSE(violation) << violation->what;
}

// They are what they claim to be: every scheme, commands, stiffness over 8 decades, masses over 6.
TEST(RandomSceneFiles, CoverTheirRanges) {
  EXPECT_TRUE(random_scenes_registered);
  std::vector<int> runs(schemes().size(), 0);
  int teleports = 0, pushes = 0;
  double softest = HUGE_VAL, stiffest = 0.0, lightest = HUGE_VAL, heaviest = 0.0;
  for (std::uint32_t seed = 1; seed <= 200; ++seed) {
    const Scene scene = randomScene(seed);
    ++runs[static_cast<std::size_t>(scene.solver.scheme)];
    for (const TimedCommand& timed : scene.timeline) {
      const auto* pin = std::get_if<PinCommand>(&timed.command);
      teleports += pin && pin->action == PinCommand::Action::kMove;
      pushes += pin == nullptr;
    }
    const auto& net = std::get<Particles>(scene.objects[0].shape);
    for (const double k : net.stiffness) {
      softest = std::min(softest, k);
      stiffest = std::max(stiffest, k);
    }
    for (const double m : net.masses) {
      lightest = std::min(lightest, m);
      heaviest = std::max(heaviest, m);
    }
  }
  for (const SchemeInfo& scheme : schemes()) {
    EXPECT_GE(runs[static_cast<std::size_t>(scheme.scheme)], 5) << scheme.name;
  }
  EXPECT_GT(teleports, 100);
  EXPECT_GT(pushes, 100);
  EXPECT_GT(stiffest / softest, 0.9e8);
  EXPECT_GT(heaviest / lightest, 0.9e6);
}

/// Positions and velocities of a step in a CSV of states.
void readState(const std::string& file, std::uint64_t wanted, Vectors& positions,
               Vectors& velocities) {
  std::ifstream lines(file);
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream numbers(line);
    double step = 0.0, time = 0.0;
    Eigen::Index particle = 0;
    numbers >> step >> time >> particle;
    if (step != static_cast<double>(wanted)) continue;
    for (Vectors* vectors : {&positions, &velocities}) {
      for (int axis = 0; axis < 3; ++axis) {
        std::string number;
        numbers >> number;
        (*vectors)(axis, particle) = std::strtod(number.c_str(), nullptr);
      }
    }
  }
}

// The file of a failure is the scene, to the last bit: `simulate` goes the same way.
TEST(RandomSceneFiles, ReproduceWithSimulate) {
  const TemporaryFolder folder;
  int failed = 0, compared = 0;
  for (std::uint32_t seed = 1; seed <= 60 && (failed < 1 || compared < 5); ++seed) {
    const Scene scene = randomScene(seed);
    Simulation simulation(scene);
    StepReport report;
    for (int n = 0; n < kSteps && report.status != StepStatus::kFailed; ++n) {
      report = simulation.step();
    }
    const bool fails = report.status == StepStatus::kFailed;
    if (fails ? failed >= 1 : compared >= 5) continue;
    ++(fails ? failed : compared);

    const std::string text =
        reproduction(seed, scene, kSteps, Violation{1, "made up"}, folder.path());
    std::istringstream command(text.substr(text.find('\n') + 1));
    std::vector<std::string> arguments;
    for (std::string word; command >> word;) arguments.push_back(word);
    ASSERT_EQ(arguments.at(0), "simulate");
    arguments[0] = programPath("simulate");
    const std::string csv = folder.path() + "/states.csv";
    arguments.insert(arguments.end(), {"--output", csv});
    const ProcessResult result = runProcess(arguments);
    EXPECT_EQ(result.status, fails ? 2 : 0) << result.err;
    if (fails) {
      EXPECT_NE(result.err.find(report.message), std::string::npos) << result.err;
    }
    Vectors positions = Vectors::Zero(3, simulation.model().particleCount());
    Vectors velocities = positions;
    readState(csv, simulation.state().step, positions, velocities);
    EXPECT_EQ(positions, simulation.state().positions) << text;
    EXPECT_EQ(velocities, simulation.state().velocities) << text;
  }
  EXPECT_EQ(failed, 1);
  EXPECT_EQ(compared, 5);
}

}  // namespace
}  // namespace mass_spring
