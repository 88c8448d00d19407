#pragma once

#include <string>

#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/simulation.h"
#include "tools/step_times.h"

namespace mass_spring {

/// What is gathered over a run beside the simulation's own totals.
class RunStatistics {
 public:
  explicit RunStatistics(const Simulation& simulation);

  /// To be called after each step.
  /// @param report   what the step returned
  /// @param seconds  that it took
  /// @param step     the number of the step
  void add(const StepReport& report, double seconds, std::uint64_t step);

  /// Takes the state into max_energy and max_stretch.
  void measure(const Simulation& simulation);

  /// Something the user has to know that no step reports.
  void remark(const std::string& text);

  /// Of the first step that was as bad as the worst, then the remarks; empty if all went well.
  std::string message() const;

  StepStatus status = StepStatus::kConverged;  ///< the worst of all steps
  StepTimes step_times;
  double setup_seconds = 0.0;  ///< reading and building
  double wall_seconds = 0.0;   ///< stepping, measuring and writing
  Energy start_energy;
  double max_energy;   ///< J, total, start included
  double max_stretch;  ///< length / rest length, start included

 private:
  std::string step_message_;
  std::string remarks_;
};

}  // namespace mass_spring
