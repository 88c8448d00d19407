#include "tools/simulate_options.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <utility>

#include "mass_spring_sim/scene_reader.h"
#include "tools/set_path.h"

namespace mass_spring {
namespace {

constexpr const char* kFooter =
    "Exit status: 0 converged or degraded (see the report), 1 scene or arguments refused,\n"
    "2 the simulation failed or its output could not be written; what came before is kept.\n"
    "Ctrl-C ends the run after the current step with all files complete: 128 + signal.";

/// Whether writing one would destroy the other; devices and pipes can be shared.
bool sameFile(const std::filesystem::path& a, const std::filesystem::path& b) {
  std::error_code error;
  if (!std::filesystem::exists(a, error)) return a.lexically_normal() == b.lexically_normal();
  return std::filesystem::is_regular_file(a, error) && std::filesystem::equivalent(a, b, error);
}

void refuseOverwriting(const SimulateOptions& options) {
  for (const std::string& file : {options.output, options.report}) {
    if (!file.empty() && sameFile(file, options.scene)) {
      throw ArgumentError("the scene " + options.scene + " would be overwritten");
    }
  }
  if (!options.output.empty() && sameFile(options.output, options.report)) {
    throw ArgumentError("--output and --report name the same file: " + options.output);
  }
}

}  // namespace

SimulateOptions readSimulateOptions(int argc, const char* const* argv) {
  CommandLine line("simulate", "Runs a scene as fast as possible, without ROS.", kFooter);
  line.addRequired("scene", "TEXT", "scene file (YAML)");
  line.addOption("duration", "FLOAT", "simulated seconds, > 0");
  line.addOption("scheme", "TEXT", "short for --set solver.scheme=NAME");
  line.addOption("rate", "TEXT", "short for --set rate=HZ");
  line.addOption("substeps", "TEXT", "short for --set solver.substeps=N");
  line.addRepeated("set", "TEXT",
                   "override one value of the scene, as PATH=VALUE; VALUE is YAML, e.g. "
                   "objects.sheet.mass=0.5; can be given again, the last one wins");
  line.addOption("every", "UINT",
                 "steps between states in the output, from 1 to 9007199254740992 (default 1)");
  line.addOption("output", "TEXT", "CSV file of states");
  line.addOption("report", "TEXT", "JSON file on how the run went");
  line.addFlag("check", "only validate the scene; --duration is not needed");
  line.parse(argc, argv);

  SimulateOptions options;
  options.scene = line.value("scene");
  const std::vector<double> duration = line.numbers(
      "duration", CommandLine::kAboveZero, std::numeric_limits<double>::max(), "seconds above 0");
  const bool check = line.has("check");
  if (!check && duration.empty()) throw line.error("--duration is required");
  if (!check) options.duration = duration.front();
  const std::pair<const char*, const char*> shortcuts[] = {
      {"scheme", "solver.scheme"}, {"rate", "rate"}, {"substeps", "solver.substeps"}};
  for (const auto& [name, path] : shortcuts) {
    for (const std::string& value : line.values(name)) {
      if (value.empty()) {
        throw line.error("--" + std::string(name) + ": got nothing, expected a value");
      }
      options.assignments.push_back(std::string(path) + "=" + value);
    }
  }
  const std::vector<std::string> sets = line.values("set");
  options.assignments.insert(options.assignments.end(), sets.begin(), sets.end());
  options.every = line.integer("every", 1, std::uint64_t{1} << 53, options.every);
  options.output = line.value("output");
  options.report = line.value("report");
  refuseOverwriting(options);
  return options;
}

Scene readSceneWith(const std::string& file, const std::vector<std::string>& assignments) {
  Tree tree = readYamlFile(file);
  for (const std::string& assignment : assignments) setPath(tree, assignment);
  const std::string directory = std::filesystem::path(file).parent_path().string();
  return readScene(tree, directory.empty() ? "." : directory);
}

std::uint64_t stepCount(double duration, double rate) {
  const double steps = std::max(std::ceil(duration * rate - 1e-9), 1.0);
  constexpr double kMost = 9007199254740992.0;  // 2^53: beyond it doubles skip integers
  if (steps > kMost) {
    throw ArgumentError("--duration: more than 2^53 steps at a rate of " + std::to_string(rate) +
                        " Hz");
  }
  return static_cast<std::uint64_t>(steps);
}

}  // namespace mass_spring
