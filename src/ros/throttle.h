#pragma once

#include <chrono>
#include <mutex>

namespace mass_spring {

/// Lets a warning through once a wall second. ROS_WARN_THROTTLE goes by ros::Time, which stands
/// still while a simulation with /use_sim_time is paused, and with it the warnings.
class Throttle {
 public:
  /// Is it time again?
  bool ready() {
    const auto now = std::chrono::steady_clock::now();
    std::lock_guard lock(mutex_);
    if (now < next_) return false;
    next_ = now + std::chrono::seconds(1);
    return true;
  }

 private:
  std::mutex mutex_;
  std::chrono::steady_clock::time_point next_;
};

}  // namespace mass_spring
