#include "mass_spring_sim/step_report.h"

#include <algorithm>

namespace mass_spring {

const char* name(StepStatus status) {
  switch (status) {
    case StepStatus::kConverged:
      return "converged";
    case StepStatus::kDegraded:
      return "degraded";
    case StepStatus::kFailed:
      break;
  }
  return "failed";
}

void StepTotals::add(const StepReport& report) {
  if (report.status != StepStatus::kFailed) ++steps;
  if (report.status != StepStatus::kConverged) ++unconverged_steps;
  substeps += report.substeps;
  newton_iterations += report.newton_iterations;
  linear_iterations += report.linear_iterations;
  factorizations += report.factorizations;
  rejected_steps += report.rejected;
  broken_springs += report.broken_springs;
  if (report.estimated_error >= 0.0) {
    estimated_error = std::max(estimated_error, 0.0) + report.estimated_error;
  }
  max_budget_used = std::max(max_budget_used, report.budget_used);
}

}  // namespace mass_spring
