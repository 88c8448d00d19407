#pragma once

#include <chrono>
#include <cstdint>

namespace mass_spring {

/// One line on standard error that is written over and over; nothing where that is no terminal.
class ProgressLine {
 public:
  /// @param step_size  s
  ProgressLine(std::uint64_t steps, double step_size);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// @param step  steps that are done
  void show(std::uint64_t step);

 private:
  using Clock = std::chrono::steady_clock;
  bool terminal_;
  bool shown_ = false;
  std::uint64_t steps_;
  double step_size_;
  Clock::time_point start_;
  Clock::time_point next_;
};

}  // namespace mass_spring
