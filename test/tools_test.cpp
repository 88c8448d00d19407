#include <gtest/gtest.h>

#include <cmath>

#include "mass_spring_sim/scene.h"
#include "tools/set_path.h"
#include "tools/simulate_options.h"
#include "tools/step_times.h"

namespace mass_spring {
namespace {

const Tree& at(const Tree& tree, const std::string& key) {
  return std::get<Tree::Map>(tree.value).at(key);
}

TEST(SetPath, MakesTheMapsThatAreMissing) {
  Tree tree;
  setPath(tree, "solver.substeps=4");
  EXPECT_EQ(std::get<std::int64_t>(at(at(tree, "solver"), "substeps").value), 4);
}

TEST(SetPath, ReplacesOneValueAndLeavesTheRest) {
  Tree tree = readYamlText("{a: {b: 1, c: 2}, d: [5, 6]}", "test");
  setPath(tree, "a.b=[1, x=y]");
  setPath(tree, "d.1={e: 7}");
  const Tree::List& list = std::get<Tree::List>(at(at(tree, "a"), "b").value);
  EXPECT_EQ(std::get<std::string>(list.at(1).value), "x=y");  // only the first = divides
  EXPECT_EQ(std::get<std::int64_t>(at(at(tree, "a"), "c").value), 2);
  const Tree::List& d = std::get<Tree::List>(at(tree, "d").value);
  EXPECT_EQ(std::get<std::int64_t>(d.at(0).value), 5);
  EXPECT_EQ(std::get<std::int64_t>(at(d.at(1), "e").value), 7);
}

TEST(SetPath, AnEmptyValueIsNull) {
  Tree tree = readYamlText("{effects: {gravity: 1}}", "test");
  setPath(tree, "effects=");
  EXPECT_TRUE(std::holds_alternative<std::monostate>(at(tree, "effects").value));
}

TEST(SetPath, RefusesPathsThatLeadNowhere) {
  for (const char* assignment : {"", "rate", "=1", "a.=1", ".a=1", "a..b=1", "rate.x=1", "d.2=1",
                                 "d.x=1", "d.-1=1", "d.1x=1", "a=[1"}) {
    Tree tree = readYamlText("{rate: 60, d: [5, 6]}", "test");
    EXPECT_THROW(setPath(tree, assignment), SceneError) << assignment;
  }
}

TEST(StepCount, CoversTheDurationWithoutASpareStep) {
  EXPECT_EQ(stepCount(1.0, 100.0), 100u);
  EXPECT_EQ(stepCount(0.29, 100.0), 29u);
  EXPECT_EQ(stepCount(0.2901, 100.0), 30u);
  EXPECT_EQ(stepCount(1e-15, 100.0), 1u);
  EXPECT_THROW(stepCount(1e300, 100.0), ArgumentError);
}

TEST(StepTimes, HasNothingToTellAtFirst) {
  const StepTimes times;
  EXPECT_EQ(times.quantile(0.5), 0.0);
  EXPECT_EQ(times.max(), 0.0);
}

TEST(StepTimes, FindsQuantilesAcrossTheScales) {
  StepTimes times;
  for (int i = 1; i <= 1000; ++i) times.add(1e-6 * std::pow(10.0, i / 200.0));
  // Half a bucket of a hundredth, and a little for its logarithm.
  EXPECT_NEAR(times.quantile(0.5) / (1e-6 * std::pow(10.0, 2.5)), 1.0, 0.0051);
  EXPECT_NEAR(times.quantile(0.99) / (1e-6 * std::pow(10.0, 4.95)), 1.0, 0.0051);
  EXPECT_DOUBLE_EQ(times.max(), 0.1);
  EXPECT_LE(times.quantile(1.0), times.max());
}

TEST(StepTimes, TakesTheExtremes) {
  StepTimes times;
  times.add(0.0);
  times.add(1e9);
  EXPECT_EQ(times.max(), 1e9);
  EXPECT_NEAR(times.quantile(0.5), 0.0, 1.01e-9);  // the first bucket
}

}  // namespace
}  // namespace mass_spring
