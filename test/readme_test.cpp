#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "mass_spring_sim/scene_reader.h"
#include "mass_spring_sim/simulation.h"

namespace mass_spring {
namespace {

// The scene that the README explains is one that loads and runs.
TEST(Readme, SceneRuns) {
  const std::string source = MASS_SPRING_SOURCE_DIR;
  std::ifstream file(source + "/README.md");
  std::stringstream content;
  content << file.rdbuf();
  const std::string text = content.str();
  const std::string fence = "```yaml\n";
  const std::size_t begin = text.find(fence) + fence.size();
  const std::size_t end = text.find("```", begin);
  ASSERT_LT(begin, end);
  const Tree tree = readYamlText(text.substr(begin, end - begin), "README.md");
  Simulation simulation(readScene(tree, source));
  EXPECT_EQ(simulation.model().objects.size(), 5u);
  for (int n = 0; n < 5; ++n) EXPECT_EQ(simulation.step().status, StepStatus::kConverged);
}

}  // namespace
}  // namespace mass_spring
