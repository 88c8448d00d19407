#include "tools/run_statistics.h"

#include <algorithm>

namespace mass_spring {

RunStatistics::RunStatistics(const Simulation& simulation)
    : start_energy(simulation.energy()),
      max_energy(start_energy.total()),
      max_stretch(maxStretch(simulation.model(), simulation.state())) {}

void RunStatistics::add(const StepReport& report, double seconds, std::uint64_t step) {
  step_times.add(seconds);
  if (report.status <= status) return;
  status = report.status;
  step_message_ = "step " + std::to_string(step) + ": " + report.message;
}

void RunStatistics::measure(const Simulation& simulation) {
  max_energy = std::max(max_energy, simulation.energy().total());
  max_stretch = std::max(max_stretch, maxStretch(simulation.model(), simulation.state()));
}

void RunStatistics::remark(const std::string& text) {
  if (!remarks_.empty()) remarks_ += "; ";
  remarks_ += text;
}

std::string RunStatistics::message() const {
  const bool both = !step_message_.empty() && !remarks_.empty();
  return step_message_ + (both ? "; " : "") + remarks_;
}

}  // namespace mass_spring
