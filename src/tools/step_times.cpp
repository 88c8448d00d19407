#include "tools/step_times.h"

#include <algorithm>
#include <cmath>

namespace mass_spring {
namespace {

constexpr double kShortest = 1e-9;  // s: the clock's own resolution
constexpr double kLongest = 1e6;    // s
const double kLogRatio = std::log(1.01);

}  // namespace

StepTimes::StepTimes()
    : counts_(static_cast<std::size_t>(std::log(kLongest / kShortest) / kLogRatio) + 1) {}

void StepTimes::add(double seconds) {
  const double bounded = std::clamp(seconds, kShortest, kLongest);
  ++counts_[static_cast<std::size_t>(std::log(bounded / kShortest) / kLogRatio)];
  ++total_;
  max_ = std::max(max_, seconds);
}

double StepTimes::quantile(double share) const {
  const double wanted = share * static_cast<double>(total_);
  double below = 0.0;
  for (std::size_t bucket = 0; bucket < counts_.size(); ++bucket) {
    below += static_cast<double>(counts_[bucket]);
    if (below > 0.0 && below >= wanted) {
      const double middle = kShortest * std::exp((static_cast<double>(bucket) + 0.5) * kLogRatio);
      return std::min(middle, max_);
    }
  }
  return 0.0;
}

}  // namespace mass_spring
