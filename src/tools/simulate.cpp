#include <chrono>
#include <fstream>
#include <iostream>
#include <optional>

#include "mass_spring_sim/scene_reader.h"
#include "mass_spring_sim/simulation.h"
#include "tools/caught_signal.h"
#include "tools/csv_writer.h"
#include "tools/file_error.h"
#include "tools/json_report.h"
#include "tools/progress_line.h"
#include "tools/run_statistics.h"
#include "tools/simulate_options.h"

namespace mass_spring {
namespace {

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::ofstream openReport(const std::string& path) {
  std::ofstream file(path);
  if (!file) throw FileError(path);
  return file;
}

/// @return false, with a message, if the file could not be written
bool writeReport(const nlohmann::json& report, const std::string& path, std::ofstream& file) {
  // File names in messages need not be UTF-8, JSON has to be.
  file << report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << std::endl;
  if (!file) std::cerr << "simulate: " << FileError(path).what() << '\n';
  return file.good();
}

/// Steps until the end, a failure or a signal.
void run(std::uint64_t steps, const SimulateOptions& options, CsvWriter* csv,
         Simulation& simulation, RunStatistics& statistics) {
  ProgressLine progress(steps, simulation.stepSize());
  if (csv) csv->write(simulation.state());
  std::uint64_t written = 0;
  while (simulation.state().step < steps && g_signal == 0) {
    const std::uint64_t step = simulation.state().step + 1;
    const Clock::time_point start = Clock::now();
    const StepReport report = simulation.step();
    statistics.add(report, secondsSince(start), step);
    if (report.status == StepStatus::kFailed) break;
    if (!options.report.empty()) statistics.measure(simulation);
    if (csv && step % options.every == 0) {
      csv->write(simulation.state());
      written = step;
    }
    progress.show(step);
  }
  const std::uint64_t last = simulation.state().step;
  // After a failure the state may be one that was written before.
  if (csv && last > written) csv->write(simulation.state());
  if (csv) csv->close();
  if (g_signal != 0 && last < steps) {
    statistics.remark("ended by signal " + std::to_string(g_signal) + " after step " +
                      std::to_string(last) + " of " + std::to_string(steps));
  }
}

int check(const Scene& scene, const std::string& file) {
  std::uint64_t particles = 0;
  for (const Object& object : scene.objects) particles += particleCount(object);
  std::cout << file << ": valid, " << scene.objects.size() << " object(s), " << particles
            << " particles\n";
  return 0;
}

void printSummary(const Simulation& simulation, const RunStatistics& statistics) {
  const std::string message = statistics.message();
  if (!simulation.model().scheme_reason.empty()) {
    std::cerr << "simulate: " << simulation.model().scheme_reason << '\n';
  }
  std::cerr << "simulate: " << name(statistics.status) << ", " << simulation.state().step
            << " steps, " << simulation.state().time << " s simulated in "
            << statistics.wall_seconds << " s" << (message.empty() ? "" : "; " + message) << '\n';
}

int simulate(const SimulateOptions& options) {
  const Clock::time_point setup = Clock::now();
  Scene scene = readSceneWith(options.scene, options.assignments);
  if (options.duration == 0.0) return check(scene, options.scene);
  const std::uint64_t steps = stepCount(options.duration, scene.rate);
  Simulation simulation(std::move(scene));
  RunStatistics statistics(simulation);
  simulation.observeTimeline([&](const Command&, const CommandResult& result) {
    if (result.accepted()) return;
    statistics.remark("timeline, before step " + std::to_string(simulation.state().step + 1) +
                      ": " + result.message);
  });
  std::optional<CsvWriter> csv;
  std::ofstream report_file;
  if (!options.output.empty()) csv.emplace(options.output);
  if (!options.report.empty()) report_file = openReport(options.report);
  statistics.setup_seconds = secondsSince(setup);

  catchSignals();
  const Clock::time_point start = Clock::now();
  try {
    run(steps, options, csv ? &*csv : nullptr, simulation, statistics);
  } catch (const FileError& error) {
    statistics.status = StepStatus::kFailed;
    statistics.remark(error.what());
  }
  statistics.wall_seconds = secondsSince(start);
  printSummary(simulation, statistics);
  if (report_file.is_open() &&
      !writeReport(jsonReport(simulation, statistics), options.report, report_file)) {
    return 2;
  }
  if (statistics.status == StepStatus::kFailed) return 2;
  return g_signal == 0 ? 0 : 128 + g_signal;
}

}  // namespace
}  // namespace mass_spring

int main(int argc, char** argv) {
  try {
    return mass_spring::simulate(mass_spring::readSimulateOptions(argc, argv));
  } catch (const mass_spring::SceneError& error) {
    std::cerr << "simulate: scene refused:\n" << error.what() << '\n';
  } catch (const std::bad_alloc&) {
    std::cerr << "simulate: not enough memory for this scene\n";
  } catch (const std::exception& error) {
    std::cerr << "simulate: " << error.what() << '\n';
  }
  return 1;  // before the first step; what happens later ends in the report
}
