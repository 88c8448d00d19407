#include "tools/study_options.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/command_line.h"

namespace mass_spring {
namespace {

constexpr const char* kStudyFooter =
    "Writes into the folder results.csv (one row per setting, failures too), summary.md (what to\n"
    "choose), work_precision.png and .svg, pareto.png, and calibration.yaml for\n"
    "solver.calibration. Ctrl-C ends it with what there is; the same command goes on from there.\n"
    "Exit status: 0 done, 1 scene or arguments refused, 2 no reference or nothing could be "
    "written,\n"
    "128 + signal when interrupted.";

constexpr double kLargest = std::numeric_limits<double>::max();

/// The schemes of these names, none twice.
std::vector<Scheme> schemesOf(const CommandLine& line) {
  std::vector<Scheme> schemes;
  for (const std::string& name : line.values("schemes")) {
    const std::optional<Scheme> scheme = schemeFromName(name);
    if (!scheme) {
      std::string known;
      for (const std::string& one : schemeNames()) known += (known.empty() ? "" : ", ") + one;
      throw line.error("--schemes: got " + name + ", expected " + known);
    }
    if (std::find(schemes.begin(), schemes.end(), *scheme) == schemes.end()) {
      schemes.push_back(*scheme);
    }
  }
  return schemes;
}

/// The rates in ascending order.
std::vector<double> ratesOf(const CommandLine& line) {
  std::vector<double> rates =
      line.numbers("rates", CommandLine::kAboveZero, 10000.0, "a rate of at most 10000 Hz");
  std::sort(rates.begin(), rates.end());
  for (const double rate : rates) {
    const double share = rate / rates.front();
    if (std::abs(share - std::round(share)) > 1e-9 * share) {
      throw line.error("--rates: got " + std::to_string(rate) +
                       ", expected a multiple of the lowest one");
    }
  }
  return rates;
}

}  // namespace

StudyOptions readStudyOptions(int argc, const char* const* argv) {
  // roslaunch adds what only nodes understand, as __name:=NAME.
  std::vector<const char*> words;
  for (int i = 0; i < argc; ++i) {
    if (std::string(argv[i]).compare(0, 2, "__") != 0) words.push_back(argv[i]);
  }
  CommandLine line("accuracy_study",
                   "Measures what accuracy costs in time on a scene, without ROS.", kStudyFooter);
  line.addRequired("scene", "TEXT", "scene file (YAML)");
  line.addRequired("duration", "FLOAT", "simulated seconds, > 0");
  line.addList("schemes", "TEXT", "names, by commas (default: all)");
  line.addList("rates", "FLOAT",
               "Hz, by commas, each a multiple of the lowest (default: from 30 Hz on, doubled)");
  line.addList("tolerances", "FLOAT", "of Newton's iteration, by commas (default: 1e-2,1e-4,1e-6)");
  line.addList("accuracies", "FLOAT",
               "m, by commas, for solver.accuracy (default: 1e-2,1e-3,1e-4,1e-5)");
  line.addRepeated("set", "TEXT",
                   "override one value of the scene, as PATH=VALUE; can be given again");
  line.addOption("time-limit", "FLOAT", "seconds for everything (default 300)");
  line.addRequired("output", "TEXT", "folder, made if missing");
  line.addFlag("no-plots", "tables only");
  line.addFlag("open", "show the plot when it is done");
  line.parse(static_cast<int>(words.size()), words.data());

  StudyOptions options;
  options.scene = line.value("scene");
  options.duration =
      line.numbers("duration", CommandLine::kAboveZero, kLargest, "seconds above 0").front();
  options.schemes = schemesOf(line);
  options.rates = ratesOf(line);
  options.tolerances = line.numbers("tolerances", CommandLine::kAboveZero, std::nextafter(1.0, 0.0),
                                    "a tolerance between 0 and 1");
  options.accuracies =
      line.numbers("accuracies", CommandLine::kAboveZero, kLargest, "meters above 0");
  options.assignments = line.values("set");
  const std::vector<double> time_limit =
      line.numbers("time-limit", CommandLine::kAboveZero, kLargest, "seconds above 0");
  if (!time_limit.empty()) options.time_limit = time_limit.front();
  options.output = line.value("output");
  options.plots = !line.has("no-plots");
  options.open = line.has("open");
  std::sort(options.tolerances.rbegin(), options.tolerances.rend());
  if (options.tolerances.empty()) options.tolerances = {1e-2, 1e-4, 1e-6};
  if (options.accuracies.empty()) options.accuracies = {1e-2, 1e-3, 1e-4, 1e-5};
  return options;
}

}  // namespace mass_spring
