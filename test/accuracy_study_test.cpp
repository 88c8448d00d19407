// The program `accuracy_study`, run as a user runs it, and what it is made of.

#include <gtest/gtest.h>
#include <signal.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "mass_spring_sim/scene_reader.h"
#include "process.h"
#include "scene_text.h"
#include "studies.h"
#include "tools/study_run.h"
#include "tools/study_table.h"

namespace mass_spring {
namespace {

namespace fs = std::filesystem;

class AccuracyStudy : public ::testing::Test {
 protected:
  AccuracyStudy() { scene_ = write("scene.yaml", kPendulum); }

  std::string path(const std::string& name) const { return folder_.path() + "/" + name; }
  std::string write(const std::string& name, const std::string& text) const {
    return folder_.write(name, text);
  }
  std::string read(const std::string& name) const { return folder_.read(name); }
  std::vector<StudyRow> rows(const std::string& name) const {
    std::ifstream file(path(name));
    return readStudyRows(file);
  }
  ProcessResult run(std::vector<std::string> arguments,
                    const std::function<void(int)>& while_running = nullptr) const {
    arguments.insert(arguments.begin(), programPath("accuracy_study"));
    return runProcess(arguments, while_running);
  }

  TemporaryFolder folder_;
  std::string scene_;
};

TEST_F(AccuracyStudy, FindsTheOrderOfEachScheme) {
  const ProcessResult result =
      run({"--scene", scene_, "--duration", "0.5", "--rates", "240,480,960", "--tolerances",
           "1e-12", "--accuracies", "1e-3", "--output", path("out")});
  ASSERT_EQ(result.status, 0) << result.err;
  std::map<Scheme, std::map<double, double>> errors;  // by rate
  for (const StudyRow& row : rows("out/results.csv")) {
    EXPECT_TRUE(row.usable()) << describe(row.setting);
    if (!row.setting.accuracy) errors[row.setting.scheme][row.setting.rate] = row.rms_error;
  }
  for (const SchemeInfo& scheme : schemes()) {
    ASSERT_EQ(errors[scheme.scheme].size(), 3u) << scheme.name;
    const double order = std::log2(errors[scheme.scheme][480.0] / errors[scheme.scheme][960.0]);
    // The next term of the expansion is some h w = 22 / 480 smaller; orders are whole numbers.
    EXPECT_NEAR(order, scheme.order, 0.15) << scheme.name;
  }
  for (const char* file : {"work_precision.png", "work_precision.svg", "pareto.png"}) {
    EXPECT_GT(fs::file_size(path("out") + "/" + file), 10000u) << file;
  }
  const std::string summary = read("out/summary.md");
  for (const char* word : {"| 10 mm |", "| 0.01 mm |", "| 1/240 s |", "compiler",
                           "that well the scene can be predicted"}) {
    EXPECT_NE(summary.find(word), std::string::npos) << word;
  }
  EXPECT_EQ(read("out/results.csv")
                .find("scheme,rate,substeps,newton_tolerance,rms_error_m,"
                      "max_error_m,energy_error_j,wall_seconds,step_median_s,"
                      "status,"),
            0u);
}

TEST_F(AccuracyStudy, IsDeterministicButForTheTimes) {
  const auto withoutTimes = [&](const std::string& folder) {
    const ProcessResult result =
        run({"--scene", scene_, "--duration", "0.2", "--schemes", "rk4,tr_bdf2,auto", "--rates",
             "240,480", "--no-plots", "--output", path(folder)});
    EXPECT_EQ(result.status, 0) << result.err;
    std::string text;
    for (StudyRow row : rows(folder + "/results.csv")) {
      row.wall_seconds = row.step_median = 0.0;
      text += toCsv(row) + '\n';
    }
    return text;
  };
  const std::string first = withoutTimes("a");
  EXPECT_GT(first.size(), 500u);
  EXPECT_EQ(first, withoutTimes("b"));
}

TEST_F(AccuracyStudy, GoesOnWhereItWasInterrupted) {
  const std::vector<std::string> arguments = {"--scene",    scene_,      "--duration",
                                              "20",         "--schemes", "rk4,ros3",
                                              "--no-plots", "--output",  path("out")};
  // Interrupted as soon as a first row is there.
  bool sent = false;  // a second signal would end it at once
  const ProcessResult first = run(arguments, [&](int process) {
    const std::string text = read("out/results.csv");
    if (sent || std::count(text.begin(), text.end(), '\n') < 3) return;
    kill(process, SIGINT);
    sent = true;
  });
  ASSERT_EQ(first.status, 128 + SIGINT) << first.err;
  const std::string kept = read("out/results.csv");
  ASSERT_FALSE(rows("out/results.csv").empty());
  EXPECT_TRUE(fs::exists(path("out/summary.md")));
  sent = false;
  const ProcessResult second = run(arguments, [&](int process) {
    if (sent || read("out/results.csv").size() <= kept.size()) return;
    kill(process, SIGINT);
    sent = true;
  });
  ASSERT_EQ(second.status, 128 + SIGINT) << second.err;
  EXPECT_EQ(read("out/results.csv").compare(0, kept.size(), kept), 0);  // times and all
  EXPECT_GT(read("out/results.csv").size(), kept.size());
}

TEST_F(AccuracyStudy, KeepsTheStudyOfAnotherScene) {
  const std::vector<std::string> common = {"--duration", "0.1",      "--schemes",
                                           "rk4",        "--rates",  "240",
                                           "--no-plots", "--output", path("out")};
  std::vector<std::string> arguments = common;
  arguments.insert(arguments.end(), {"--scene", scene_});
  ASSERT_EQ(run(arguments).status, 0);
  const std::string before = read("out/results.csv");
  arguments.insert(arguments.end(), {"--set", "objects.bob.stiffness=60.0"});
  const ProcessResult other = run(arguments);
  EXPECT_EQ(other.status, 1);
  EXPECT_NE(other.err.find("holds the study of another scene"), std::string::npos) << other.err;
  EXPECT_EQ(read("out/results.csv"), before);
}

// Failures are rows, not gaps; and a reference that is far finer still stands.
TEST_F(AccuracyStudy, TellsWhatExploded) {
  const ProcessResult result =
      run({"--scene", scene_, "--set", "objects.bob.stiffness=1e6", "--duration", "0.1",
           "--schemes", "explicit_euler,symplectic_euler,rk4,tr_bdf2", "--rates", "60,120",
           "--tolerances", "1e-6", "--no-plots", "--output", path("out")});
  ASSERT_EQ(result.status, 0) << result.err;
  for (const StudyRow& row : rows("out/results.csv")) {
    const bool is_explicit = !info(row.setting.scheme).implicit;
    EXPECT_EQ(row.status == "exploded" || row.status == "failed", is_explicit)
        << describe(row.setting) << ": " << row.status;
  }
  EXPECT_EQ(rows("out/results.csv").size(), 8u + 4u);  // and the scene's own scheme by accuracy
}

TEST_F(AccuracyStudy, RefusesBadArguments) {
  const std::vector<std::string> good = {"--scene",    scene_,     "--duration", "0.1",
                                         "--no-plots", "--output", path("out")};
  const std::pair<std::vector<std::string>, const char*> bad[] = {
      {{"--schemes", "rk5"}, "got rk5, expected explicit_euler"},
      {{"--rates", "60,90"}, "multiple of the lowest"},
      {{"--rates", "0"}, "--rates"},
      {{"--tolerances", "nan"}, "--tolerances"},
      {{"--tolerances", "1"}, "--tolerances"},
      {{"--time-limit", "-1"}, "--time-limit"},
      {{"--duration", "inf"}, "--duration"},
      {{"--set", "objects.bob.masses=-1"}, "objects.bob.masses"},
  };
  for (const auto& [words, message] : bad) {
    std::vector<std::string> arguments = good;
    arguments.insert(arguments.end(), words.begin(), words.end());
    const ProcessResult result = run(arguments);
    EXPECT_EQ(result.status, 1) << words[1];
    EXPECT_NE(result.err.find(message), std::string::npos) << result.err;
  }
  EXPECT_FALSE(fs::exists(path("out")));
  const ProcessResult no_folder = run({"--scene", scene_, "--duration", "1e6", "--output", scene_});
  EXPECT_EQ(no_folder.status, 2);  // at once, not after a reference of 1e6 s
  EXPECT_NE(no_folder.err.find("scene.yaml"), std::string::npos) << no_folder.err;
}

// With a calibration, an accuracy is that of the positions against the reference.
TEST(Calibration, KeepsItsPromiseOnTheScene) {
  Scene scene = readScene(readYamlText(kPendulum, "pendulum"), "");
  scene.rate = 60.0;
  Study study = studyOf(scene, 0.5);
  for (const double accuracy : {1e-5, 1e-4, 1e-3, 1e-2}) {
    const StudyRow row = measure(study, {Scheme::kTrBdf2, 60.0, 0, {}, accuracy}, INFINITY);
    study.scene.solver.calibration.push_back({accuracy, row.rms_error});
  }
  for (const double wanted : {2e-5, 1e-4, 5e-4}) {
    SolverOptions solver = study.scene.solver;
    solver.accuracy = wanted;
    const StudyRow row =
        measure(study, {Scheme::kTrBdf2, 60.0, 0, {}, controlledAccuracy(solver)}, INFINITY);
    // Sub-steps are powers of two: the error moves in steps of up to 4.
    EXPECT_LT(row.rms_error, 2.0 * wanted);
    EXPECT_GT(row.rms_error, wanted / 8.0);
  }
}

TEST(Calibration, InterpolatesAndNeverExceedsWhatWasMeasured) {
  SolverOptions solver;
  EXPECT_EQ(controlledAccuracy(solver), std::nullopt);
  solver.accuracy = 1e-3;
  EXPECT_EQ(controlledAccuracy(solver), 1e-3);
  solver.calibration = {{1e-4, 1e-5}, {1e-2, 1e-3}};
  EXPECT_EQ(controlledAccuracy(solver), 1e-2);
  // Powers of ten, but for the rounding of logarithms.
  solver.accuracy = 1e-4;
  EXPECT_NEAR(*controlledAccuracy(solver), 1e-3, 1e-12);
  solver.accuracy = 1e-6;  // in proportion, but for one rounding
  EXPECT_NEAR(*controlledAccuracy(solver), 1e-5, 1e-14);
  solver.accuracy = 1.0;
  EXPECT_EQ(controlledAccuracy(solver), 1e-2);
}

TEST_F(AccuracyStudy, MakesACalibrationThatScenesTake) {
  const ProcessResult result = run({"--scene", scene_, "--duration", "0.2", "--schemes", "auto",
                                    "--no-plots", "--output", path("out")});
  ASSERT_EQ(result.status, 0) << result.err;
  const auto read = [&](const std::string& solver) {
    Tree tree = readYamlFile(scene_);
    std::get<Tree::Map>(tree.value)["solver"] = readYamlText(solver, "solver");
    return readScene(tree, folder_.path());
  };
  const Scene scene = read("{accuracy: 0.001, calibration: out/calibration.yaml}");
  EXPECT_EQ(scene.solver.calibration.size(), 4u);
  EXPECT_NE(toYaml(scene).find("calibration: "), std::string::npos);
  write("broken.yaml", "auto: [{accuracy: 0.1, error: -1.0}]");
  const std::pair<const char*, const char*> bad[] = {
      {"{calibration: out/calibration.yaml}", "together with an accuracy"},
      {"{accuracy: 0.001, calibration: none.yaml}", "none.yaml"},
      {"{accuracy: 0.001, calibration: 3}", "solver.calibration"},
      {"{accuracy: 0.001, scheme: rk4, calibration: out/calibration.yaml}", "measured with auto"},
      {"{accuracy: 0.001, calibration: broken.yaml}", "auto[0].error"},
  };
  for (const auto& [solver, message] : bad) {
    try {
      read(solver);
      ADD_FAILURE() << solver;
    } catch (const SceneError& error) {
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace mass_spring
