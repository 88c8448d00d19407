#pragma once

#include <chrono>
#include <cstdint>
#include <deque>

namespace mass_spring {

/// How fast steps are computed, over the last wall second.
class StepMeter {
 public:
  using Time = std::chrono::steady_clock::time_point;

  struct Figures {
    double real_time_factor = 0.0;  ///< simulated s per wall s
    double median = 0.0;            ///< s of computing per step
    double max = 0.0;               ///< s
  };

  /// @param step_size  s of simulated time
  explicit StepMeter(double step_size) : step_size_(step_size) {}

  /// Steps follow each other from now on: the time before does not count as slowness.
  void start(Time now);
  /// A step has ended that took so long to compute.
  void add(Time end, double seconds);
  /// Refreshed ten times a second at the most, as very fast simulations do many steps in one.
  const Figures& figures(Time now);

 private:
  struct Sample {
    Time end;
    double seconds;
  };

  double step_size_;
  Time started_;
  Time measured_;
  std::deque<Sample> samples_;
  Figures figures_;
};

}  // namespace mass_spring
