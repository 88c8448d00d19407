#pragma once

#include <cstdint>
#include <string>

#include "mass_spring_sim/scheme.h"

namespace mass_spring {

enum class StepStatus : std::uint8_t {
  kConverged,  ///< to the tolerances of the scene
  kDegraded,   ///< finite, but not computed as asked for: see the message
  kFailed,     ///< not finite, or beyond the limits; the state is an earlier one
};

/// "converged", "degraded", "failed"
const char* name(StepStatus status);

/// The result of one step. Steps never throw; they report.
struct StepReport {
  StepStatus status = StepStatus::kConverged;
  std::string message;              ///< empty if converged; else the remedy, or object and particle
  Scheme scheme = Scheme::kTrBdf2;  ///< that made the step
  std::uint32_t substeps = 0;
  std::uint32_t newton_iterations = 0;  ///< linear systems set up, over all sub-steps
  std::uint32_t linear_iterations = 0;  ///< of conjugate gradients; 0 with a direct solver
  std::uint32_t factorizations = 0;
  std::uint32_t projected_springs = 0;  ///< whose stiffness was made positive semidefinite
  std::uint32_t broken_springs = 0;     ///< that tearing removed after the step
  std::uint32_t rejected = 0;           ///< attempts thrown away and redone another way
  double residual = 0.0;                ///< largest relative residual of the equations solved
  /// m, sum of the sub-steps' estimates (root mean square over the free particles); -1 = the scheme
  /// has no estimate.
  double estimated_error = -1.0;
  double budget_used = -1.0;  ///< time the step took / solver.budget; -1 = there is none
};

/// Sums over the steps since start or reset.
struct StepTotals {
  std::uint64_t steps = 0;
  std::uint64_t substeps = 0;
  std::uint64_t newton_iterations = 0;
  std::uint64_t linear_iterations = 0;
  std::uint64_t factorizations = 0;
  std::uint64_t unconverged_steps = 0;  ///< degraded or failed
  std::uint64_t rejected_steps = 0;
  std::uint64_t broken_springs = 0;
  double estimated_error = -1.0;  ///< m, sum of the steps' estimates; -1 = there is none
  double max_budget_used = -1.0;  ///< of all steps; -1 = there is no budget
  void add(const StepReport& report);
};

}  // namespace mass_spring
