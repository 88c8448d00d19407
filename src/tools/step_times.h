#pragma once

#include <cstdint>
#include <vector>

namespace mass_spring {

/// How long steps took, in constant memory however many there are: counts over buckets that grow by
/// a hundredth, so that quantiles err by half a per cent at the most.
class StepTimes {
 public:
  StepTimes();

  /// @param seconds  >= 0
  void add(double seconds);

  /// The time [s] that a share of the steps did not exceed; 0 before the first step.
  /// @param share  (0, 1]
  double quantile(double share) const;

  double max() const { return max_; }  ///< s, exact

 private:
  std::vector<std::uint64_t> counts_;
  std::uint64_t total_ = 0;
  double max_ = 0.0;
};

}  // namespace mass_spring
