#include "tools/simulate_options.h"

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>

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
  SimulateOptions options;
  CLI::App app("Runs a scene as fast as possible, without ROS.", "simulate");
  app.footer(kFooter);
  app.add_option("--scene", options.scene, "scene file (YAML)")->required();
  CLI::Option* const duration =
      app.add_option("--duration", options.duration, "simulated seconds, > 0")
          ->check([](const std::string& text) {
            double value = 0.0;
            const bool number = CLI::detail::lexical_cast(text, value);
            return number && std::isfinite(value) && value > 0.0
                       ? std::string()
                       : "got " + text + ", expected seconds above 0";
          });
  std::string scheme, rate, substeps;
  const auto not_empty = [](const std::string& text) {
    return text.empty() ? std::string("got nothing, expected a value") : std::string();
  };
  app.add_option("--scheme", scheme, "short for --set solver.scheme=NAME")->check(not_empty);
  app.add_option("--rate", rate, "short for --set rate=HZ")->check(not_empty);
  app.add_option("--substeps", substeps, "short for --set solver.substeps=N")->check(not_empty);
  std::vector<std::string> sets;
  app.add_option("--set", sets,
                 "override one value of the scene, as PATH=VALUE; VALUE is YAML, e.g. "
                 "objects.sheet.mass=0.5; can be given again, the last one wins")
      ->allow_extra_args(false);
  app.add_option("--every", options.every, "steps between states in the output (default 1)")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1} << 53));
  app.add_option("--output", options.output, "CSV file of states");
  app.add_option("--report", options.report, "JSON file on how the run went");
  bool check = false;
  app.add_flag("--check", check, "only validate the scene; --duration is not needed");

  try {
    app.parse(argc, argv);
    if (!check && duration->count() == 0) throw CLI::RequiredError("--duration");
  } catch (const CLI::Success& help) {
    std::exit(app.exit(help));
  } catch (const CLI::ParseError& error) {
    throw ArgumentError(std::string(error.what()) + " (see simulate --help)");
  }
  if (check) options.duration = 0.0;
  const std::pair<const char*, const std::string&> shortcuts[] = {
      {"solver.scheme", scheme}, {"rate", rate}, {"solver.substeps", substeps}};
  for (const auto& [path, value] : shortcuts) {
    if (!value.empty()) options.assignments.push_back(std::string(path) + "=" + value);
  }
  options.assignments.insert(options.assignments.end(), sets.begin(), sets.end());
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
