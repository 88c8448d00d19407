#include "step_budget.h"

#include <algorithm>
#include <cmath>

namespace mass_spring {
namespace {

// A sub-step that the operating system interrupts may take a hundred times as long, and says
// nothing about the next one. Slower scenes are still learned within some ten sub-steps.
constexpr double kLargestRise = 4.0;
constexpr double kShare = 0.1;  // of a new cost in the mean
// Mean deviations above the mean: 3.75 of them are three standard deviations of a normal
// distribution.
constexpr double kDeviations = 3.75;

}  // namespace

double StepBudget::spent() const {
  return std::chrono::duration<double>(Clock::now() - start_).count();
}

int StepBudget::affordableSubsteps(bool cheap, int most) const {
  const Cost& cost = cheap ? cheap_ : asked_;
  // Of a cost that is not known yet, one sub-step tells.
  if (cost.mean == 0.0) return 1;
  // The last one must fit even if it is slow; those before it may make up for one another.
  const double substeps = 1.0 + (kUse * seconds_ - spent() - cost.upper()) / cost.mean;
  return static_cast<int>(std::clamp(substeps, 1.0, static_cast<double>(most)));
}

double StepBudget::Cost::upper() const { return mean + kDeviations * deviation; }

void StepBudget::Cost::learn(double seconds) {
  if (mean == 0.0) {
    mean = seconds;
    return;
  }
  const double difference = std::min(seconds, kLargestRise * mean) - mean;
  deviation += kShare * (std::abs(difference) - deviation);
  mean += kShare * difference;
}

void StepBudget::learn(bool cheap, double seconds) {
  (cheap ? cheap_ : asked_).learn(seconds);
  if (!cheap && affordable()) pause_ = kFirstPause;
}

void StepBudget::forget() {
  if (++waited_ < pause_) return;
  waited_ = 0;
  pause_ = std::min(pause_ * kPauseGrowth, kLongestPause);
  asked_ = Cost();
}

}  // namespace mass_spring
