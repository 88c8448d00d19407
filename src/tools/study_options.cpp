#include "tools/study_options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "tools/simulate_options.h"

namespace mass_spring {
namespace {

constexpr const char* kStudyFooter =
    "Writes into the folder results.csv (one row per setting, failures too), summary.md (what to\n"
    "choose), work_precision.png and .svg, pareto.png, and calibration.yaml for\n"
    "solver.calibration. Ctrl-C ends it with what there is; the same command goes on from there.\n"
    "Exit status: 0 done, 1 scene or arguments refused, 2 no reference or nothing could be "
    "written,\n"
    "128 + signal when interrupted.";

/// A finite number above 0, and below `high`.
CLI::Validator between(double high, const std::string& what) {
  return CLI::Validator(
      [high, what](std::string& text) {
        double value = 0.0;
        const bool number = CLI::detail::lexical_cast(text, value);
        return number && std::isfinite(value) && value > 0.0 && value < high
                   ? std::string()
                   : "got " + text + ", expected " + what;
      },
      "");
}

}  // namespace

StudyOptions readStudyOptions(int argc, const char* const* argv) {
  // roslaunch adds what only nodes understand, as __name:=NAME.
  std::vector<const char*> words;
  for (int i = 0; i < argc; ++i) {
    if (std::string(argv[i]).compare(0, 2, "__") != 0) words.push_back(argv[i]);
  }
  StudyOptions options;
  CLI::App app("Measures what accuracy costs in time on a scene, without ROS.", "accuracy_study");
  app.footer(kStudyFooter);
  const double unbounded = HUGE_VAL;
  app.add_option("--scene", options.scene, "scene file (YAML)")->required();
  app.add_option("--duration", options.duration, "simulated seconds, > 0")
      ->required()
      ->check(between(unbounded, "seconds above 0"));
  std::vector<std::string> schemes;
  app.add_option("--schemes", schemes, "names, by commas (default: all)")->delimiter(',');
  app.add_option("--rates", options.rates,
                 "Hz, by commas, each a multiple of the lowest (default: from 30 Hz on, doubled)")
      ->delimiter(',')
      ->check(between(10000.5, "a rate of at most 10000 Hz"));
  app.add_option("--tolerances", options.tolerances,
                 "of Newton's iteration, by commas (default: 1e-2,1e-4,1e-6)")
      ->delimiter(',')
      ->check(between(1.0, "a tolerance between 0 and 1"));
  app.add_option("--accuracies", options.accuracies,
                 "m, by commas, for solver.accuracy (default: 1e-2,1e-3,1e-4,1e-5)")
      ->delimiter(',')
      ->check(between(unbounded, "metres above 0"));
  app.add_option("--set", options.assignments,
                 "override one value of the scene, as PATH=VALUE; can be given again")
      ->allow_extra_args(false);
  app.add_option("--time-limit", options.time_limit, "seconds for everything (default 300)")
      ->check(between(unbounded, "seconds above 0"));
  app.add_option("--output", options.output, "folder, made if missing")->required();
  bool no_plots = false;
  app.add_flag("--no-plots", no_plots, "tables only");
  app.add_flag("--open", options.open, "show the plot when it is done");
  try {
    app.parse(static_cast<int>(words.size()), words.data());
    for (const std::string& word : schemes) {
      const std::optional<Scheme> scheme = schemeFromName(word);
      if (!scheme) {
        std::string known;
        for (const std::string& one : schemeNames()) known += (known.empty() ? "" : ", ") + one;
        throw CLI::ValidationError("--schemes", "got " + word + ", expected " + known);
      }
      if (std::find(options.schemes.begin(), options.schemes.end(), *scheme) ==
          options.schemes.end()) {
        options.schemes.push_back(*scheme);
      }
    }
    std::sort(options.rates.begin(), options.rates.end());
    for (const double rate : options.rates) {
      const double share = rate / options.rates.front();
      if (std::abs(share - std::round(share)) > 1e-9 * share) {
        throw CLI::ValidationError(
            "--rates", "got " + std::to_string(rate) + ", expected a multiple of the lowest one");
      }
    }
  } catch (const CLI::Success& help) {
    std::exit(app.exit(help));
  } catch (const CLI::ParseError& error) {
    throw ArgumentError(std::string(error.what()) + " (see accuracy_study --help)");
  }
  std::sort(options.tolerances.rbegin(), options.tolerances.rend());
  options.plots = !no_plots;
  if (options.tolerances.empty()) options.tolerances = {1e-2, 1e-4, 1e-6};
  if (options.accuracies.empty()) options.accuracies = {1e-2, 1e-3, 1e-4, 1e-5};
  return options;
}

}  // namespace mass_spring
