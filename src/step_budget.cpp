#include "step_budget.h"

#include <algorithm>

namespace mass_spring {

double StepBudget::spent() const {
  return std::chrono::duration<double>(Clock::now() - start_).count();
}

int StepBudget::affordableSubsteps(bool cheap, int most) const {
  const double cost = cheap ? cheap_cost_ : cost_;
  // Of a cost that is not known yet, one sub-step tells.
  if (cost == 0.0) return 1;
  const double substeps = (kUse * seconds_ - spent()) / cost;
  return static_cast<int>(std::clamp(substeps, 1.0, static_cast<double>(most)));
}

void StepBudget::learn(bool cheap, double seconds) {
  double& cost = cheap ? cheap_cost_ : cost_;
  cost = std::max(seconds, kForgetting * cost + (1.0 - kForgetting) * seconds);
}

}  // namespace mass_spring
