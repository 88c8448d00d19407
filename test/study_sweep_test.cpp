#include "tools/study_sweep.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "mass_spring_sim/scene_reader.h"
#include "mass_spring_sim/tree.h"
#include "studies.h"
#include "tools/study_table.h"

namespace mass_spring {
namespace {

namespace fs = std::filesystem;

// The studies that the documentation shows are of this program: its columns, all of its schemes.
TEST(StudyTable, ReadsTheStudiesOfTheDocumentation) {
  const fs::path folder = fs::path(MASS_SPRING_SOURCE_DIR) / "docs" / "accuracy";
  int studies = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (!entry.is_directory()) continue;
    ++studies;
    std::ifstream file(entry.path() / "results.csv");
    std::map<std::string, int> by_scheme;
    for (const StudyRow& row : readStudyRows(file)) ++by_scheme[name(row.setting.scheme)];
    for (const std::string& scheme : schemeNames()) {
      EXPECT_GE(by_scheme[scheme], 1) << entry.path() << ": " << scheme;
    }
    EXPECT_TRUE(fs::exists(entry.path() / "work_precision.png")) << entry.path();
  }
  EXPECT_EQ(studies, 4);
}

TEST(StudyTable, ComesBackFromItsFile) {
  StudyRow row;
  row.setting = {Scheme::kTrBdf2, 240.0, 2, 1e-6, std::nullopt};
  row.rms_error = 1.0 / 3.0;
  row.max_error = INFINITY;
  row.status = "degraded";
  row.totals.steps = 123456789012345;
  std::istringstream file(studyHeader() + '\n' + toCsv(row) + '\n' + toCsv(row).substr(0, 30));
  const std::vector<StudyRow> rows = readStudyRows(file);
  ASSERT_EQ(rows.size(), 1u);  // the last line was not written to its end
  EXPECT_EQ(toCsv(rows[0]), toCsv(row));
  EXPECT_TRUE(rows[0].setting == row.setting);
  std::istringstream broken(studyHeader() + "\nrk4,60\n");
  EXPECT_THROW(readStudyRows(broken), std::runtime_error);
  std::istringstream foreign("a,b\n");
  EXPECT_THROW(readStudyRows(foreign), std::runtime_error);
}

TEST(StudyTable, FindsTheFrontier) {
  std::vector<StudyRow> rows(5);
  const double errors[] = {1e-2, 1e-3, 5e-3, 1e-4, 1e-9}, seconds[] = {1.0, 2.0, 3.0, 4.0, 0.1};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].rms_error = errors[i];
    rows[i].wall_seconds = seconds[i];
    rows[i].status = i == 4 ? "failed" : "converged";
  }
  const std::vector<StudyRow> best = frontier(rows);
  ASSERT_EQ(best.size(), 3u);
  EXPECT_EQ(best[1].rms_error, 1e-3);
  EXPECT_EQ(cheapest(rows, 6e-3), &rows[1]);
  EXPECT_EQ(cheapest(rows, 1e-5), nullptr);
}

/// A row of what errs by `error` [m], or explodes.
StudyRow rowOf(const StudySetting& setting, std::optional<double> error) {
  StudyRow row;
  row.setting = setting;
  row.status = error ? "converged" : "exploded";
  row.rms_error = error.value_or(INFINITY);
  row.wall_seconds = 1e-6 * setting.stepRate();
  return row;
}

TEST(StudySeries, FindsTheEdgeOfStabilityToAThird) {
  Scene scene = readScene(readYamlText(kPendulum, "pendulum"), "");
  StudyOptions options;
  options.schemes = {Scheme::kRk4};
  // Wherever the edge is, in steps a second: where rates are doubled, where sub-steps are.
  for (const double edge : {35.0, 70.0, 190.0, 250.0, 410.0, 900.0, 3500.0, 5000.0}) {
    StudySeries series = makeSeries(scene, options)[0];
    while (series.end.empty()) {
      const StudySetting& setting = series.settings[series.next];
      const double rate = setting.stepRate();
      series.add(
          rowOf(setting, rate < edge ? std::nullopt : std::optional(1e6 / std::pow(rate, 3))),
          1e-5);
    }
    EXPECT_EQ(series.end, "far below the finest error of interest");
    std::size_t stable = 0;
    while (!series.rows[stable].usable()) ++stable;
    double coarser = 0.0;
    for (const StudyRow& row : series.rows) {
      EXPECT_GT(row.setting.stepRate(), coarser);
      EXPECT_EQ(row.setting.rate / 30.0, std::round(row.setting.rate / 30.0));  // whole frames
      coarser = row.setting.stepRate();
    }
    // Frames have whole numbers of steps: nothing lies between one and two, or three and four.
    EXPECT_LE(series.rows[stable].setting.stepRate(), std::max(1.34 * edge, edge + 30.0)) << edge;
    EXPECT_LE(series.settings.size(), 19u);  // 17 doublings and two more
  }
}

TEST(StudySeries, EndsWhereFinerStepsGainNothing) {
  const Scene scene = readScene(readYamlText(kPendulum, "pendulum"), "");
  StudyOptions options;
  options.schemes = {Scheme::kBdf2};
  options.tolerances = {1e-2, 1e-6};
  std::vector<StudySeries> all = makeSeries(scene, options);
  StudySeries &loose = all[0], &tight = all[1];
  EXPECT_EQ(looserThan(loose, all), nullptr);
  ASSERT_EQ(looserThan(tight, all), &loose);
  const auto add = [](StudySeries& series, double error) {
    series.add(rowOf(series.settings[series.next], error), 1e-5);
  };
  for (const double error : {1e-1, 3e-2}) add(loose, error), add(tight, 0.95 * error);
  EXPECT_TRUE(tight.isNoBetterThan(loose));
  for (const double error : {1e-2, 9e-3, 8e-3}) add(loose, error);
  EXPECT_EQ(loose.end, "no longer gained by finer steps");
  EXPECT_FALSE(tight.isNoBetterThan(loose));  // it may be Newton's tolerance that it errs by
}

TEST(StudySeries, KeepsATighterToleranceThatErrsLessOrCostsLess) {
  const Scene scene = readScene(readYamlText(kPendulum, "pendulum"), "");
  StudyOptions options;
  options.schemes = {Scheme::kBdf2};
  options.tolerances = {1e-2, 1e-6};
  for (const auto& [error, iterations] : {std::pair(0.5, 10), std::pair(1.0, 3)}) {
    std::vector<StudySeries> all = makeSeries(scene, options);
    for (const double loose_error : {1e-1, 3e-2}) {
      for (StudySeries& series : all) {
        StudyRow row = rowOf(series.settings[series.next], loose_error);
        row.totals.newton_iterations = 5;
        if (&series == &all[1]) {
          row.rms_error *= error;
          row.totals.newton_iterations = static_cast<std::uint64_t>(iterations);
        }
        series.add(row, 1e-5);
      }
    }
    EXPECT_FALSE(all[1].isNoBetterThan(all[0])) << error;
  }
}

}  // namespace
}  // namespace mass_spring
