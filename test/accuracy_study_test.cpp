// The program `accuracy_study`, run as a user runs it, and what it is made of.

#include <gtest/gtest.h>
#include <signal.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <complex>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/scene_reader.h"
#include "process.h"
#include "scene_text.h"
#include "stability_function.h"
#include "tools/closed_form.h"
#include "tools/set_path.h"
#include "tools/study_end.h"
#include "tools/study_run.h"
#include "tools/study_sweep.h"
#include "tools/study_table.h"

namespace mass_spring {
namespace {

namespace fs = std::filesystem;

// A pendulum on a spring: 22 rad/s along it, 7 rad/s across.
constexpr const char* kPendulum = R"(
rate: 240.0
solver: {scheme: tr_bdf2, threads: 1}
objects:
  bob:
    type: particles
    positions: [[0.0, 0.0, 1.0], [0.2, 0.0, 1.0]]
    masses: 0.1
    springs: [[0, 1]]
    stiffness: 50.0
    damping: 0.01
pins:
  nail: {object: bob, particles: [0]}
effects:
  gravity: {acceleration: [0.0, 0.0, -9.81]}
)";

// A bob that bounces on a damped spring below a pin: linear, and every scheme's answer is known.
constexpr const char* kBouncing = R"(
rate: 60.0
solver: {scheme: tr_bdf2, newton_tolerance: 1.0e-12, threads: 1}
objects:
  bob:
    type: particles
    positions: [[0.0, 0.0, 1.0], [0.0, 0.0, 0.45]]
    masses: 0.1
    springs: [[0, 1]]
    stiffness: 50.0
    damping: 0.3
    rest_lengths: 0.52
pins: {nail: {object: bob, particles: [0]}}
effects: {gravity: {acceleration: [0.0, 0.0, -9.81]}}
)";

/// A study of a scene whose frames come at its rate, without a program around it.
Study studyOf(const Scene& scene, double duration) {
  Study study;
  study.scene = scene;
  study.duration = duration;
  study.frame_rate = study.scene.rate;
  ReferenceOptions options;
  options.duration = duration;
  options.frame_rate = study.frame_rate;
  study.reference = findReference(study.scene, options);
  study.compared = study.reference.frames.size();
  study.modes = findModes(study.scene, study.reference, study.frame_rate, study.compared);
  return study;
}
Study studyOf(const std::string& scene, double duration) {
  return studyOf(readScene(readYamlText(scene, "scene"), ""), duration);
}

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
    arguments.insert(arguments.begin(), MASS_SPRING_ACCURACY_STUDY_PATH);
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

TEST(Reference, EndsItsHorizonWhereTwoStartsPart) {
  Reference reference;
  reference.spread = {1e-9, 1e-6, 1e-4, 1e-5, 1e-2};
  EXPECT_EQ(reference.horizon(1e-4), 2u);  // what falls again does not bring knowledge back
  EXPECT_EQ(reference.horizon(1.0), 5u);
  EXPECT_EQ(reference.horizon(1e-10), 0u);
}

// A triple pendulum forgets its start within seconds.
constexpr const char* kTriplePendulum = R"(
rate: 60.0
solver: {scheme: tr_bdf2, threads: 1}
objects:
  chain:
    type: particles
    positions: [[0.0, 0.0, 0.0], [0.1, 0.0, 0.02], [0.2, 0.01, 0.0], [0.3, 0.0, 0.05]]
    masses: 0.1
    springs: [[0, 1], [1, 2], [2, 3]]
    stiffness: 300.0
pins: {nail: {object: chain, particles: [0]}}
effects: {gravity: {acceleration: [0.0, 0.0, -9.81]}}
)";

TEST(End, TellsTheSpreadOfStartsBeyondTheHorizon) {
  Study study = studyOf(kTriplePendulum, 8.0);
  const Reference& reference = study.reference;
  ASSERT_LT(reference.horizon(1e-3), reference.frames.size());
  ASSERT_EQ(reference.ends.size(), kStarts);
  for (std::size_t a = 0; a < kStarts; ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      EXPECT_GT(reference.distance(reference.ends[a].positions, reference.ends[b].positions), 1e-3);
    }
  }
  StudyRow row;
  row.setting = {Scheme::kRk4, 60.0, 1, {}, {}};
  row.status = "converged";
  row.end_height = 100.0;
  EXPECT_NE(endText(study, {row}).find("| rk4, 60 Hz | "), std::string::npos);
  EXPECT_NE(endText(study, {row}).find(" m | no |"), std::string::npos);
  row.end_height = meanHeight(study.scene, reference.ends[0]);
  row.end_energy = energy(buildModel(study.scene), reference.ends[0]).total();
  EXPECT_EQ(endText(study, {row}).find("| no |"), std::string::npos);  // it is one of them
  study = studyOf(kBouncing, 0.2);
  EXPECT_EQ(study.reference.ends.size(), 1u);
}

TEST(End, KnowsTheStatisticsOfAFew) {
  const Statistics some = statistics({1.0, 2.0, 3.0, 6.0});
  EXPECT_DOUBLE_EQ(some.mean, 3.0);
  EXPECT_DOUBLE_EQ(some.deviation, std::sqrt(14.0 / 3.0));
  EXPECT_DOUBLE_EQ(some.deviations(3.0), 0.0);
  EXPECT_DOUBLE_EQ(some.deviations(3.0 - 2.0 * some.deviation), -2.0);
  EXPECT_LT(usualDeviations(4), usualDeviations(3));
}

// Three particles on their own: one on a damped spring, one overdamped and thrown, one that falls.
TEST(ClosedForm, AgreesWithRk4) {
  constexpr const char* kScene = R"(
rate: 50.0
objects:
  net:
    type: particles
    positions: [[0.0, 0.0, 1.0], [0.0, 0.0, 0.7], [1.0, 0.0, 1.0], [1.0, 0.0, 0.6], [2.0, 0.0, 0.0]]
    velocities: [[0, 0, 0], [0, 0, 0.2], [0, 0, 0], [0, 0, -0.5], [1.0, 0.0, 2.0]]
    masses: 0.1
    springs: [[0, 1], [3, 2]]
    stiffness: 50.0
    damping: [0.3, 9.0]
    rest_lengths: 0.35
pins: {nails: {object: net, particles: [0, 2]}}
effects: {gravity: {acceleration: [0.0, 0.0, -9.81]}}
)";
  const Tree tree = readYamlText(kScene, "net");
  ReferenceOptions options;
  options.duration = 1.0;
  options.frame_rate = 50.0;
  const Reference reference = findReference(readScene(tree, ""), options);
  ASSERT_TRUE(reference.exact);
  ASSERT_EQ(reference.frames.size(), 50u);
  // h = 1/2000 s at 22 rad/s, and 90 1/s: (h w)^4 = 1e-8 and 4e-6 of some centimetres, decaying.
  EXPECT_LT(reference.largestDoubt(50), 1e-9);
  EXPECT_GT(reference.distance(reference.frames[0].positions, reference.frames[9].positions), 0.01);
  // Whatever couples particles, or acts across a spring, has none.
  for (const char* change :
       {"objects.net.springs=[[0, 1], [1, 3]]", "objects.net.springs=[[0, 1], [3, 4]]",
        "effects.gravity.acceleration=[1.0, 0.0, -9.81]", "objects.net.rest_lengths=0.0"}) {
    Tree other = tree;
    setPath(other, change);
    EXPECT_FALSE(closedForm(readScene(other, ""), {0.1})) << change;
  }
}

/// The oscillation of e^(s t).
Oscillation oscillationOf(const std::complex<double>& s) {
  return {std::abs(s.imag()) / (2.0 * M_PI), -s.real() / std::abs(s)};
}

TEST(Modes, FindADampedOscillationExactly) {
  const double d = 0.7, w = 9.0, interval = 0.02;
  std::vector<double> samples;
  for (int n = 0; n < 50; ++n) {
    const double t = n * interval;
    samples.push_back(3.0 + 0.01 * std::exp(-d * t) * std::cos(w * t + 0.4));
  }
  const Oscillation truth = oscillationOf({-d, w});
  for (const std::size_t stride : {1, 5}) {
    const auto found = fitOscillation(samples, interval, stride);
    ASSERT_TRUE(found);
    // Rounding of 3 is 1e-14 of the swing, and some h w = 0.18 to the second power is taken of it.
    EXPECT_NEAR(found->frequency, truth.frequency, 1e-10);
    EXPECT_NEAR(found->damping, truth.damping, 1e-10);
    EXPECT_LT(found->misfit, 1e-12);
  }
  EXPECT_FALSE(fitOscillation(std::vector<double>(50, 3.0), interval, 1));
  samples.resize(5);
  EXPECT_FALSE(fitOscillation(samples, interval, 1));
}

TEST(Modes, ErrAsTheTheoryOfEachScheme) {
  const Study study = studyOf(kBouncing, 1.0);
  ASSERT_EQ(study.modes.modes.size(), 1u) << study.modes.reason;
  const double w2 = 50.0 / 0.1, c = 0.3 / 0.1;
  const Oscillation exact = oscillationOf({-0.5 * c, std::sqrt(w2 - 0.25 * c * c)});
  const Mode& mode = study.modes.modes[0];
  // A closed form, and a matrix of one spring: rounding, over the digits that differences cost.
  for (const Oscillation& known : {mode.linear, mode.truth}) {
    EXPECT_NEAR(known.frequency / exact.frequency, 1.0, 1e-10);
    EXPECT_NEAR(known.damping, exact.damping, 1e-10);
  }
  for (const SchemeInfo& scheme : schemes()) {
    for (const double rate : {60.0, 240.0}) {
      const double h = 1.0 / rate;
      std::complex<double> lambda;  // over one step
      if (const auto r = stabilityFunction(scheme.scheme, h, w2, c)) {
        lambda = r->eigenvalues()[0];
      } else {
        // bdf2: 3/2 l^2 - 2 l + 1/2 = h s l^2, and the root that tends to 1.
        ASSERT_EQ(scheme.name, "bdf2");
        const std::complex<double> s(-0.5 * c, std::sqrt(w2 - 0.25 * c * c));
        const std::complex<double> a = 1.5 - h * s;
        lambda = (2.0 + std::sqrt(4.0 - 2.0 * a)) / (2.0 * a);
      }
      const Oscillation theory = oscillationOf(std::log(lambda) * rate);
      const StudyRow row = measure(study, {scheme.scheme, rate, 1, {}, {}}, INFINITY);
      ASSERT_TRUE(row.mode_errors) << scheme.name;
      // One-step schemes obey the recurrence exactly, to Newton's tolerance and rounding. bdf2's
      // other root, about 1/3, and its first step add something for the first few frames.
      const double tolerance = scheme.name == "bdf2" ? 1e-3 : 1e-9;
      EXPECT_NEAR(row.mode_errors->frequency, std::abs(theory.frequency / exact.frequency - 1.0),
                  tolerance)
          << scheme.name << ' ' << rate;
      EXPECT_NEAR(row.mode_errors->damping, std::abs(theory.damping - exact.damping), tolerance)
          << scheme.name << ' ' << rate;
    }
  }
}

// N beads on a string of tension T, a apart: w_j = 2 sqrt(T / (a m)) sin(j pi / (2 (N + 1))).
TEST(Modes, MeetTheStringWithBeads) {
  const int n = 9;
  const double a = 0.1, m = 0.01, k = 100.0, rest_length = 0.09;
  std::string positions, springs;
  for (int i = 0; i <= n + 1; ++i) {
    const double phase = M_PI * i / (n + 1);
    const double y = i <= n ? 1e-4 * std::sin(phase) + 5e-5 * std::sin(2.0 * phase) : 0.0;
    positions += (i ? ", [" : "[") + std::to_string(a * i) + ", " + std::to_string(y) + ", 0.0]";
    if (i <= n) {
      springs += (i ? ", [" : "[") + std::to_string(i) + ", " + std::to_string(i + 1) + "]";
    }
  }
  std::ostringstream scene;
  scene << "{rate: 60.0, solver: {threads: 1, newton_tolerance: 1.0e-10}, objects: {string: {type: "
           "particles, positions: ["
        << positions << "], springs: [" << springs << "], masses: " << m << ", stiffness: " << k
        << ", rest_lengths: " << rest_length << "}}, pins: {ends: {object: string, particles: [0, "
        << n + 1 << "]}}}";
  const Study study = studyOf(scene.str(), 1.0);
  ASSERT_GE(study.modes.modes.size(), 2u) << study.modes.reason;
  double shares[2] = {};
  double largest = 0.0;  // error of implicit_midpoint: tan(w' h / 2) = w h / 2
  for (const Mode& mode : study.modes.modes) {
    // Across the string each mode is there twice, in any two directions.
    const int j = 2.0 * M_PI * mode.linear.frequency < 15.0 ? 1 : 2;
    const double w =
        2.0 * std::sqrt(k * (a - rest_length) / (a * m)) * std::sin(j * M_PI / (2.0 * (n + 1)));
    EXPECT_NEAR(2.0 * M_PI * mode.linear.frequency / w, 1.0, 1e-9);  // rest to 1e-6, squared
    // The tension grows by k / T = 10 / a^2 times the squared slope, (1e-4 pi / 1)^2 = 1e-7.
    EXPECT_NEAR(2.0 * M_PI * mode.truth.frequency / w, 1.0, 1e-5);
    EXPECT_NEAR(mode.truth.damping, 0.0, 1e-5);
    shares[j - 1] += mode.share;
    largest = std::max(largest, 1.0 - 120.0 * std::atan(w / 120.0) / w);
  }
  for (const double share : shares) EXPECT_NEAR(share, 0.5, 0.02);  // (j times half) squared
  const StudyRow row = measure(study, {Scheme::kImplicitMidpoint, 60.0, 1, {}, {}}, INFINITY);
  ASSERT_TRUE(row.mode_errors);
  EXPECT_NEAR(row.mode_errors->frequency, largest, 2e-5);  // both as above
  EXPECT_NEAR(row.mode_errors->damping, 0.0, 2e-5);
}

TEST(Modes, AreThoseNearRestOnly) {
  EXPECT_NE(studyOf(kPendulum, 1.0).modes.reason, "");  // it swings by a right angle
  // Let go far off, it comes near: what it swings by falls by e^-5 in a second.
  Tree tree = readYamlText(kBouncing, "bouncing");
  setPath(tree, "objects.bob.positions.1=[0.0, 0.0, 0.8]");
  setPath(tree, "objects.bob.damping=1.0");
  const Study study = studyOf(readScene(tree, ""), 1.0);
  EXPECT_EQ(study.modes.modes.size(), 1u) << study.modes.reason;
  EXPECT_GT(study.modes.first, 5u);
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
