#include "error_control.h"

#include <algorithm>
#include <cmath>

namespace mass_spring {
namespace {

// Over how long a time the estimates may add up to the accuracy [s].
constexpr double kTime = 1.0;
// With these exponents a sub-step is doubled when its error is below 0.23 of the tolerance (0.11 of
// it for order 3): it will then be 2^order times as much.
constexpr double kSafety = 0.8;
constexpr double kIntegral = 0.7, kProportional = 0.4;
constexpr double kSmallestRatio = 1e-4;

}  // namespace

bool ErrorControl::accepts(double error, double substep) {
  const double ratio = error * kTime / (accuracy_ * substep);
  coarsened_ = false;
  if (!(ratio <= 1.0) && level_ < kFinest) {
    const double halvings = std::isfinite(ratio) ? std::log2(ratio) / order_ : 1.0;
    level_ = std::min(level_ + std::clamp(static_cast<int>(std::ceil(halvings)), 1, 3), kFinest);
    wanted_ = level_;
    ratio_before_ = 1.0;
    return false;
  }
  if (!std::isfinite(ratio)) return false;
  const double bounded = std::max(ratio, kSmallestRatio);
  const double factor = kSafety * std::pow(bounded, -kIntegral / order_) *
                        std::pow(ratio_before_, kProportional / order_);
  ratio_before_ = bounded;
  wanted_ = std::clamp(wanted_ - std::log2(factor), level_ - 1.0, level_ + 1.0);
  if (wanted_ <= level_ - 1.0 && level_ > 0) {
    --level_;
    coarsened_ = true;
  } else if (wanted_ > level_ + 0.5 && level_ < kFinest) {
    ++level_;
  }
  return true;
}

void ErrorControl::refine() {
  level_ = std::min(level_ + 1, kFinest);
  wanted_ = level_;
  ratio_before_ = 1.0;
}

}  // namespace mass_spring
