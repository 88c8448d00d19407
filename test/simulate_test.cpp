// The program `simulate`, run as a user runs it.

#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "process.h"
#include "scene_text.h"

namespace mass_spring {
namespace {

using Lines = std::vector<std::string>;

// A pendulum that stretches, and a weight that falls beside it.
constexpr const char* kScene = R"(
rate: 100.0
solver: {scheme: symplectic_euler}
objects:
  bob:
    type: particles
    positions: [[0.0, 0.0, 1.0], [0.3, 0.0, 1.0]]
    masses: 0.1
    springs: [[0, 1]]
    stiffness: 50.0
  weight:
    type: particles
    positions: [[1.0, 0.0, 0.0]]
    masses: 0.5
    springs: []
    stiffness: 1.0
pins:
  nail: {object: bob, particles: [0]}
effects:
  gravity: {acceleration: [0.0, 0.0, -10.0]}
)";

class Simulate : public ::testing::Test {
 protected:
  Simulate() { scene_ = write("scene.yaml", kScene); }

  std::string path(const std::string& name) const { return folder_.path() + "/" + name; }
  std::string write(const std::string& name, const std::string& text) const {
    return folder_.write(name, text);
  }
  std::string read(const std::string& name) const { return folder_.read(name); }
  Lines readLines(const std::string& name) const {
    std::istringstream text(read(name));
    Lines lines;
    for (std::string line; std::getline(text, line);) lines.push_back(line);
    return lines;
  }
  nlohmann::json readReport() const { return nlohmann::json::parse(read("report.json")); }

  ProcessResult run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), programPath("simulate"));
    return runProcess(arguments);
  }
  ProcessResult runScene(std::vector<std::string> more) const {
    more.insert(more.begin(), {"--scene", scene_});
    return run(more);
  }

  void expectRefused(const ProcessResult& result, const std::string& word) const {
    EXPECT_EQ(result.status, 1) << result.err;
    EXPECT_EQ(result.out, "");
    EXPECT_NE(result.err.find(word), std::string::npos) << result.err;
    EXPECT_EQ(result.err.rfind("simulate: ", 0), 0u) << result.err;
  }

  TemporaryFolder folder_;
  std::string scene_;
};

std::vector<double> numbers(const std::string& line) {
  std::istringstream text(line);
  std::vector<double> result;
  for (std::string cell; std::getline(text, cell, ',');) result.push_back(std::stod(cell));
  return result;
}

TEST_F(Simulate, WritesTheStartEveryNthStepAndTheLast) {
  ASSERT_EQ(runScene({"--duration", "0.08", "--every", "3", "--output", path("out.csv")}).status,
            0);
  const Lines lines = readLines("out.csv");
  ASSERT_EQ(lines.size(), 1u + 4u * 3u);
  EXPECT_EQ(lines[0], "step,time,particle,x,y,z,vx,vy,vz");
  const double steps[] = {0, 3, 6, 8};
  for (int row = 0; row < 12; ++row) {
    const std::vector<double> cells = numbers(lines[1 + row]);
    ASSERT_EQ(cells.size(), 9u);
    EXPECT_EQ(cells[0], steps[row / 3]);
    EXPECT_DOUBLE_EQ(cells[1], steps[row / 3] / 100.0);
    EXPECT_EQ(cells[2], row % 3);
  }
  // Symplectic Euler falls by g h^2 n (n + 1) / 2; the weight is the third particle.
  // 1e-12: a handful of roundings of numbers below 1.
  EXPECT_NEAR(numbers(lines[12])[5], -10.0 * 1e-4 * 8 * 9 / 2, 1e-12);
  EXPECT_EQ(numbers(lines[1]), (std::vector<double>{0, 0, 0, 0, 0, 1, 0, 0, 0}));
}

TEST_F(Simulate, WritesSeventeenDigitsAndTheSameBytesEachTime) {
  ASSERT_EQ(runScene({"--duration", "1", "--output", path("a.csv")}).status, 0);
  ASSERT_EQ(runScene({"--duration", "1", "--output", path("b.csv")}).status, 0);
  EXPECT_EQ(read("a.csv"), read("b.csv"));
  const Lines lines = readLines("a.csv");
  EXPECT_EQ(lines[2], "0,0,1,0.29999999999999999,0,1,0,0,0");
  for (std::size_t row = 1; row < lines.size(); ++row) {
    std::istringstream text(lines[row]);
    for (std::string cell; std::getline(text, cell, ',');) {
      char again[40];
      std::snprintf(again, sizeof again, "%.17g", std::stod(cell));
      ASSERT_EQ(cell, again) << lines[row];
    }
  }
}

TEST_F(Simulate, RepeatsImplicitStepsToTheByte) {
  for (const char* name : {"a.csv", "b.csv"}) {
    ASSERT_EQ(
        runScene({"--scheme", "implicit_euler", "--duration", "1", "--output", path(name)}).status,
        0);
  }
  EXPECT_EQ(read("a.csv"), read("b.csv"));
}

TEST_F(Simulate, CoversTheDurationWithWholeSteps) {
  // 0.29 * 100 is 28.999999999999996 in doubles, 0.07 * 100 is 7.000000000000001.
  const std::pair<const char*, int> cases[] = {
      {"0.29", 29}, {"0.07", 7}, {"0.071", 8}, {"1e-12", 1}};
  for (const auto& [duration, steps] : cases) {
    ASSERT_EQ(runScene({"--duration", duration, "--report", path("report.json")}).status, 0);
    EXPECT_EQ(readReport()["steps"], steps) << duration;
  }
}

TEST_F(Simulate, ReportsTheRun) {
  ASSERT_EQ(
      runScene({"--duration", "0.5", "--substeps", "2", "--report", path("report.json")}).status,
      0);
  const nlohmann::json report = readReport();
  EXPECT_EQ(report["scheme"], "symplectic_euler");
  EXPECT_EQ(report["steps"], 50);
  EXPECT_EQ(report["substeps_total"], 100);
  EXPECT_DOUBLE_EQ(report["simulated_seconds"], 0.5);
  EXPECT_EQ(report["particles"], 3);
  EXPECT_EQ(report["springs"], 1);
  EXPECT_EQ(report["effects"], (std::vector<std::string>{"springs", "gravity"}));
  for (const char* zero : {"newton_iterations", "linear_iterations", "factorizations",
                           "matrix_nonzeros", "unconverged_steps", "rejected_steps"}) {
    EXPECT_EQ(report[zero], 0) << zero;
  }
  EXPECT_TRUE(report["estimated_error"].is_null());
  EXPECT_TRUE(report["max_budget_used"].is_null());
  EXPECT_EQ(report["scheme_reason"], "");
  EXPECT_EQ(report["status"], "converged");
  EXPECT_EQ(report["message"], "");

  const nlohmann::json& seconds = report["step_seconds"];
  EXPECT_GT(seconds["median"], 0.0);
  EXPECT_LE(seconds["median"], seconds["p99"]);
  EXPECT_LE(seconds["p99"], seconds["max"]);
  EXPECT_LE(seconds["max"], report["wall_seconds"]);
  EXPECT_GT(report["setup_seconds"], 0.0);

  // Two particles of 0.1 kg at height 1 m, at rest, in a field of 10 m/s^2.
  const nlohmann::json& energy = report["energy"];
  EXPECT_EQ(energy["start"]["kinetic"], 0.0);
  EXPECT_EQ(energy["start"]["elastic"], 0.0);
  EXPECT_DOUBLE_EQ(energy["start"]["gravity"], 2.0);
  EXPECT_DOUBLE_EQ(energy["start"]["total"], 2.0);
  EXPECT_GE(energy["max_total"], energy["end"]["total"]);
  EXPECT_DOUBLE_EQ(energy["end"]["total"], energy["end"]["kinetic"].get<double>() +
                                               energy["end"]["elastic"].get<double>() +
                                               energy["end"]["gravity"].get<double>());
  EXPECT_GT(report["max_stretch"], 1.0);
  EXPECT_TRUE(report["pins"].is_object());
  EXPECT_EQ(report.size(), 24u);
}

TEST_F(Simulate, ReportsHowManySpringsBroke) {
  ASSERT_EQ(runScene({"--duration", "0.5", "--report", path("report.json")}).status, 0);
  EXPECT_FALSE(readReport().contains("broken_springs"));
  // It starts at rest, and is stretched by m g / k = 0.02 m and more.
  ASSERT_EQ(runScene({"--duration", "0.5", "--report", path("report.json"), "--set",
                      "effects.tearing.max_strain=0.01"})
                .status,
            0);
  const nlohmann::json report = readReport();
  EXPECT_EQ(report["broken_springs"], 1);
  EXPECT_EQ(report["springs"], 0);
  EXPECT_EQ(report["effects"], (std::vector<std::string>{"gravity", "tearing"}));
}

TEST_F(Simulate, CountsTheWorkOfImplicitSteps) {
  ASSERT_EQ(
      runScene({"--scheme", "implicit_euler", "--duration", "0.5", "--report", path("report.json")})
          .status,
      0);
  const nlohmann::json report = readReport();
  EXPECT_EQ(report["scheme"], "implicit_euler");
  EXPECT_GE(report["newton_iterations"], report["steps"]);
  // Three particles, one coupled pair: 3 + 2 blocks of nine.
  EXPECT_EQ(report["matrix_nonzeros"], 45);
}

TEST_F(Simulate, OverridesValuesOfTheScene) {
  const std::vector<std::string> arguments = {
      "--rate",     "50",
      "--duration", "0.1",
      "--set",      "effects.gravity.acceleration=[0, 0, -1]",
      "--set",      "objects.weight.masses=2",
      "--set",      "solver.substeps=1",
      "--set",      "solver.substeps=4",
      "--set",      "solver.linear_solver=cholesky",
      "--report",   path("report.json"),
      "--output",   path("out.csv")};
  const ProcessResult result = runScene(arguments);
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_EQ(readReport()["steps"], 5);
  EXPECT_EQ(readReport()["substeps_total"], 20);
  EXPECT_EQ(readReport()["energy"]["start"]["gravity"], 0.2);
  // 20 sub-steps of 5 ms: g h^2 n (n + 1) / 2. 1e-12: as above.
  EXPECT_NEAR(numbers(readLines("out.csv").back())[5], -1.0 * 25e-6 * 20 * 21 / 2, 1e-12);
}

TEST_F(Simulate, LetsTheReaderJudgeOverrides) {
  const std::pair<const char*, const char*> cases[] = {
      {"solver.schema=implicit_euler", "did you mean 'scheme'"},
      {"objects.nobody.mass=1", "objects.nobody"},
      {"rate=.nan", "rate"},
      {"solver.scheme=[1, 2", "solver.scheme"},
      {"solver.scheme.name=1", "solver.scheme.name"},
      {"objects..mass=1", "empty key"},
      {"=1", "empty key"},
      {"rate", "PATH=VALUE"},
      {"objects.bob.positions.2=[0, 0, 0]", "below 2"},
      {"objects.bob.positions.-1=[0, 0, 0]", "below 2"}};
  for (const auto& [assignment, word] : cases) {
    SCOPED_TRACE(assignment);
    expectRefused(runScene({"--duration", "1", "--set", assignment}), word);
  }
}

TEST_F(Simulate, ChecksWithoutRunning) {
  const ProcessResult good = runScene({"--check"});
  EXPECT_EQ(good.status, 0);
  EXPECT_NE(good.out.find("valid, 2 object(s), 3 particles"), std::string::npos) << good.out;
  EXPECT_EQ(good.err, "");
  expectRefused(runScene({"--check", "--set", "rate=0"}), "rate");
  EXPECT_EQ(runScene({"--check", "--output", path("out.csv"), "--duration", "1"}).status, 0);
  EXPECT_FALSE(std::filesystem::exists(path("out.csv")));
}

TEST_F(Simulate, RefusesBadArguments) {
  const std::vector<std::pair<Lines, std::string>> cases = {
      {{}, "--duration"},
      {{"--duration", "0"}, "--duration"},
      {{"--duration", "-1"}, "--duration"},
      {{"--duration", "nan"}, "--duration"},
      {{"--duration", "inf"}, "--duration"},
      {{"--duration", "1s"}, "--duration"},
      {{"--duration", ""}, "--duration"},
      {{"--duration", "1e300"}, "--duration"},
      {{"--duration", "1", "--every", "0"}, "--every"},
      {{"--duration", "1", "--every", "-1"}, "--every"},
      {{"--duration", "1", "--every", "1.5"}, "--every"},
      {{"--duration", "1", "--rate", "fast"}, "rate"},
      {{"--duration", "1", "--rate", ""}, "rate"},
      {{"--duration", "1", "--substeps", "0"}, "solver.substeps"},
      {{"--duration", "1", "--scheme", "magic"}, "solver.scheme"},
      {{"--duration", "1", "--wings", "2"}, "--wings"},
      {{"--duration", "1", "stray"}, "stray"},
      {{"--duration", "1", "--output"}, "--output"},
      {{"--duration", "1", "--output", path("no/such/folder.csv")}, "no/such/folder.csv"},
      {{"--duration", "1", "--report", path("no/such/folder.json")}, "no/such/folder.json"},
      {{"--duration", "1", "--output", folder_.path()}, "directory"},
      {{"--duration", "1", "--output", "/dev/full"}, "No space left"},
      {{"--duration", "1", "--output", scene_}, "overwritten"},
      {{"--duration", "1", "--report", scene_}, "overwritten"},
      {{"--duration", "1", "--output", path("x"), "--report", path("./x")}, "same file"},
  };
  for (const auto& [arguments, word] : cases) {
    SCOPED_TRACE(::testing::PrintToString(arguments));
    expectRefused(runScene(arguments), word);
  }
  expectRefused(run({"--duration", "1"}), "--scene");
  EXPECT_EQ(read("scene.yaml"), kScene);
}

TEST_F(Simulate, SaysWhenTheReportCannotBeWritten) {
  const ProcessResult result = runScene({"--duration", "0.1", "--report", "/dev/full"});
  EXPECT_EQ(result.status, 2);
  EXPECT_NE(result.err.find("/dev/full"), std::string::npos) << result.err;
}

TEST_F(Simulate, KeepsWhatCameBeforeAFailedStep) {
  // Explicit Euler on a spring far too stiff for its step grows without bound.
  const ProcessResult result =
      runScene({"--scheme", "explicit_euler", "--set", "objects.bob.stiffness=1e12", "--duration",
                "100", "--report", path("report.json"), "--output", path("out.csv")});
  EXPECT_EQ(result.status, 2);
  const nlohmann::json report = readReport();
  EXPECT_EQ(report["status"], "failed");
  // "step 4: ...; the state is that of step 0"
  const std::string message = report["message"];
  std::smatch numbers_of;
  ASSERT_TRUE(std::regex_match(message, numbers_of,
                               std::regex(R"(step (\d+): .*; the state is that of step (\d+))")))
      << message;
  const std::uint64_t failed = std::stoul(numbers_of[1]), good = std::stoul(numbers_of[2]);
  EXPECT_LT(failed, 10000u);
  EXPECT_LT(good, failed);
  EXPECT_EQ(report["steps"], good);
  // The start and each step but the one that failed: how it has exploded can be seen.
  const Lines lines = readLines("out.csv");
  ASSERT_EQ(lines.size(), 1 + 3 * failed);
  for (const double cell : numbers(lines.back())) EXPECT_TRUE(std::isfinite(cell));
}

TEST_F(Simulate, EndsOnInterruptWithCompleteFiles) {
  const std::string csv = path("out.csv");
  bool sent = false;
  const ProcessResult result =
      runProcess({programPath("simulate"), "--scene", scene_, "--duration", "1e9", "--output", csv,
                  "--report", path("report.json")},
                 [&](int child) {
                   // The header is written before signals are caught, the first states after.
                   std::error_code error;
                   if (!sent && std::filesystem::file_size(csv, error) > 1000 && !error) {
                     sent = kill(child, SIGINT) == 0;
                   }
                 });
  EXPECT_EQ(result.status, 128 + SIGINT) << result.err;
  const nlohmann::json report = readReport();
  EXPECT_EQ(report["status"], "converged");
  EXPECT_NE(report["message"].get<std::string>().find("ended by signal 2"), std::string::npos);
  EXPECT_EQ(numbers(readLines("out.csv").back())[0], report["steps"]);
}

TEST_F(Simulate, RefusesFilesOfAnyContent) {
  std::string binary(4096, '\0');
  for (std::size_t i = 0; i < binary.size(); ++i) binary[i] = static_cast<char>(i * 7 % 256);
  std::string bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 30; ++i) {
    const std::string last = "*a" + std::to_string(i - 1);
    bomb += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + last;
    for (int j = 0; j < 8; ++j) bomb += ", " + last;
    bomb += "]\n";
  }
  const std::vector<std::pair<std::string, std::string>> contents = {
      {"empty", ""},
      {"spaces", "  \n\n"},
      {"scalar", "42\n"},
      {"list", "[1, 2]\n"},
      {"binary", binary},
      {"brackets", std::string(1000000, '[')},
      {"braces", std::string(1000000, '{')},
      {"dashes",
       [] {
         std::string text;
         for (int i = 0; i < 100000; ++i) text += "- ";
         return text;
       }()},
      {"bomb", bomb},
      {"self", "objects: &a {b: *a}\n"},
      {"no_objects", "rate: 100.0\n"},
      {"truncated", std::string(kScene).substr(0, 120)},
      {"huge_grid",
       "objects: {a: {type: cloth, size: [1, 1], resolution: [2000000000, 2000000000],"
       " mass: 1, stiffness: 1}}\n"},
  };
  for (const auto& [name, text] : contents) {
    SCOPED_TRACE(name);
    expectRefused(run({"--scene", write(name, text), "--duration", "1"}), "");
  }
  expectRefused(run({"--scene", path("missing.yaml"), "--duration", "1"}), "missing.yaml");
  expectRefused(run({"--scene", folder_.path(), "--duration", "1"}), "");
  expectRefused(run({"--scene", "", "--duration", "1"}), "");
}

TEST_F(Simulate, RefusesAHundredMegabytes) {
  std::string text = "objects:\n";
  while (text.size() < (100u << 20)) text += "  - [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]\n";
  expectRefused(run({"--scene", write("big.yaml", text), "--duration", "1"}), "big.yaml");
}

TEST_F(Simulate, ShowsHelp) {
  const ProcessResult result = run({"--help"});
  EXPECT_EQ(result.status, 0);
  for (const char* option : {"--scene", "--duration", "--scheme", "--rate", "--substeps", "--set",
                             "--every", "--output", "--report", "--check"}) {
    EXPECT_NE(result.out.find(option), std::string::npos) << option;
  }
}

}  // namespace
}  // namespace mass_spring
