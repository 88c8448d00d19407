#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <stdexcept>

#include "recorded_run.h"
#include "replayer.h"
#include "tools/file_error.h"

namespace mass_spring {
namespace {

constexpr const char* kFooter =
    "Exit status: 0 the run is the same bit for bit, 1 arguments or bag refused, also a bag that\n"
    "lacks commands, 2 the run is not the same.";

// So many of the ways in which runs differ are told in full.
constexpr std::size_t kMostRefused = 10;

struct Options {
  std::vector<std::string> bags;
  std::string node, timeline;
};

Options readOptions(int argc, char** argv) {
  Options options;
  CLI::App app(
      "Does a run of mass_spring_node again, out of a recording of its topics ~scene, ~applied "
      "and\n"
      "~state, and compares the states.",
      "replay");
  app.footer(kFooter);
  app.add_option("bag", options.bags,
                 "the bag, or all those that rosbag record --split has made of one recording")
      ->required();
  app.add_option("--node", options.node,
                 "name of the node, e.g. /mass_spring, where several were recorded");
  app.add_option("--to-timeline", options.timeline,
                 "scene file to write, which does the run since the last reset in simulate");
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help) {
    std::exit(app.exit(help));
  } catch (const CLI::ParseError& error) {
    throw std::runtime_error(std::string(error.what()) + " (see replay --help)");
  }
  for (const std::string& bag : options.bags) {
    std::error_code error;
    if (!options.timeline.empty() && std::filesystem::equivalent(bag, options.timeline, error)) {
      throw std::runtime_error("the bag " + bag + " would be overwritten");
    }
  }
  return options;
}

void print(const char* which, const Difference& difference) {
  const char* const unit = difference.velocity ? " m/s" : " m";
  std::cout << which << " difference: step " << difference.step << ", " << difference.object
            << ", particle " << difference.particle << ", "
            << (difference.velocity ? "velocity" : "position") << '\n'
            << std::setprecision(17) << "  recorded   " << difference.recorded.transpose() << unit
            << '\n'
            << "  simulated  " << difference.simulated.transpose() << unit << '\n'
            << "  distance   " << std::setprecision(3) << difference.distance() << unit << '\n';
}

void print(const RecordedRun& run, const Replayer& replayer) {
  const Comparison& comparison = replayer.comparison();
  if (comparison.missed_commands > 0) {
    std::cout << "The recording began late: " << comparison.missed_commands
              << " commands came before it. Compared from its first reset on.\n";
  }
  if (comparison.budget) {
    std::cout << "The scene has a solver.budget: its steps depend on how fast the machine is.\n";
  }
  for (std::size_t i = 0; i < std::min(comparison.refused.size(), kMostRefused); ++i) {
    std::cout << comparison.refused[i] << '\n';
  }
  if (comparison.refused.size() > kMostRefused) {
    std::cout << "and " << comparison.refused.size() - kMostRefused << " more such commands\n";
  }
  if (comparison.first) print("first", *comparison.first);
  if (comparison.largest) print("largest", *comparison.largest);
  std::cout << run.node() << ": " << comparison.commands << " commands, " << comparison.restarts
            << " times started over, " << comparison.states << " states compared: ";
  if (!comparison.same()) {
    std::cout << comparison.differing_states << " differ\n"
              << "Another build of the package or another number of threads (here solver.threads "
              << replayer.simulation().scene().solver.threads
              << ", 0 = all cores) round otherwise.\n";
  } else if (comparison.states == 0) {
    std::cout << "nothing was compared; record ~state\n";
  } else {
    std::cout << "all the same, bit for bit\n";
  }
}

void write(const Replayer& replayer, const std::string& path) {
  const std::string yaml = replayer.timeline().toYaml();
  std::ofstream file(path);
  file << yaml;
  file.close();
  if (!file) throw FileError(path);
  std::cout << path << ": the run"
            << (replayer.comparison().restarts > 0 ? " since it last started over" : "")
            << std::setprecision(15) << "; simulate --scene " << path << " --duration "
            << replayer.simulation().state().time << '\n';
}

int replay(const Options& options) {
  RecordedRun run(options.bags, options.node);
  Replayer replayer(run);
  replayer.run();
  print(run, replayer);
  if (!options.timeline.empty()) write(replayer, options.timeline);
  return replayer.comparison().same() ? 0 : 2;
}

}  // namespace
}  // namespace mass_spring

int main(int argc, char** argv) {
  try {
    return mass_spring::replay(mass_spring::readOptions(argc, argv));
  } catch (const mass_spring::SceneError& error) {
    std::cerr << "replay: scene refused:\n" << error.what() << '\n';
  } catch (const rosbag::BagException& error) {
    std::cerr << "replay: the bag is damaged: " << error.what() << '\n';
  } catch (const std::exception& error) {
    std::cerr << "replay: " << error.what() << '\n';
  }
  return 1;
}
