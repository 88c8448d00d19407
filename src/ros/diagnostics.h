#pragma once

#include <diagnostic_updater/diagnostic_updater.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <set>
#include <string>
#include <thread>

#include "mass_spring_sim/simulation.h"
#include "step_meter.h"

namespace mass_spring {

/// What operators look at, on /diagnostics once a wall second, also while the simulation is paused:
/// timing, solver, state, commands and pins. Has a thread of its own; what happens may be told from
/// any thread.
class Diagnostics {
 public:
  /// @param follows_clock  steps are due when others say so
  explicit Diagnostics(bool follows_clock);
  ~Diagnostics();

  /// Of a simulation that stands at its start, or goes on.
  void started(const Simulation& simulation);
  /// @param stale_pins, stale_shapes  names of what has lost its frame
  void stepped(const StepReport& report, const StepMeter::Figures& figures, std::uint64_t overruns,
               const Simulation& simulation, const std::set<std::string>& stale_pins,
               const std::set<std::string>& stale_shapes);
  /// A step failed, and nothing goes on.
  void failed(const std::string& message);
  void paused(bool paused);
  void applied();
  void rejected(const std::string& message);

 private:
  using Status = diagnostic_updater::DiagnosticStatusWrapper;

  void run();
  void timing(Status& status);
  void solver(Status& status);
  void state(Status& status);
  void commands(Status& status);
  void pins(Status& status);
  template <class Change>
  void change(Change change);

  /// What has been told, and since the last report.
  struct Told {
    bool paused = false;
    double asked_factor = 1.0;  ///< 0 = as fast as possible
    double period = 0.0;        ///< s of wall time from step to step; 0 = as fast as possible
    bool measured = false;      ///< a step was done since the start, or the end of a pause
    StepMeter::Figures figures;
    std::uint64_t overruns = 0;
    std::chrono::steady_clock::time_point last_step;

    StepReport report;
    StepTotals totals;
    std::uint64_t degraded = 0;  ///< steps since the last report
    std::string degraded_message;

    std::uint64_t step = 0;
    double time = 0.0;
    std::uint32_t particles = 0;
    std::string failure;

    std::uint64_t applied = 0, rejected = 0;
    std::uint64_t newly_rejected = 0;  ///< since the last report
    std::string rejected_message;

    std::size_t pins = 0;
    std::set<std::string> stale_pins, stale_shapes;
  };

  const bool follows_clock_;
  std::mutex mutex_;
  std::condition_variable stopped_;
  bool stopping_ = false;
  Told told_;
  Told reported_;  ///< what a report is about; of the thread
  diagnostic_updater::Updater updater_;
  std::thread thread_;
};

}  // namespace mass_spring
