#pragma once

#include <ros/ros.h>

#include <chrono>
#include <mutex>

namespace mass_spring {

/// The time that messages carry. With /use_sim_time the node is the clock master and publishes
/// simulated time on /clock, which never jumps back, not even when the simulation does. Without,
/// it is wall time. Physics is paced by neither.
class Clock {
 public:
  /// @param master  publish /clock; warns if another node does so, too
  Clock(ros::NodeHandle& nh, bool master);

  /// A step has ended. @param sim_time  s since start or reset
  void advance(double sim_time);
  /// Simulated time starts again at 0; the clock stands still until the next step.
  void restart();
  /// Publishes /clock unchanged if it has not been published for a while, so that nodes which
  /// come while the simulation is paused know the time.
  void repeat();

  /// When the last step (or reset) ended.
  ros::Time stamp() const;
  /// Between steps, wall time goes on and simulated time does not.
  ros::Time now() const;

 private:
  void set(const ros::Time& stamp);

  const bool master_;
  ros::Publisher publisher_;
  ros::Time start_;  ///< the clock when simulated time was 0
  std::chrono::steady_clock::time_point published_;
  mutable std::mutex mutex_;  ///< of stamp_, which all threads read
  ros::Time stamp_;
};

}  // namespace mass_spring
