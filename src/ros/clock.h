#pragma once

#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <rosgraph_msgs/Clock.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>

namespace mass_spring {

/// The time that messages carry, and the one that paces the steps. As the clock master the node
/// publishes simulated time on /clock, which never jumps back, not even when the simulation does,
/// and is paced by the steady clock; so it is where messages carry wall time. Or it follows the
/// /clock of others in both.
class Clock {
 public:
  enum class Source { kWall, kMaster, kFollowed };

  /// A master warns if another node publishes /clock, too.
  Clock(ros::NodeHandle& nh, Source source);
  ~Clock();

  /// The steady clock, or the /clock that is followed.
  using Pace = std::chrono::steady_clock::time_point;
  /// Unless nothing has come on the /clock that is followed.
  std::optional<Pace> pace() const;
  bool followed() const { return source_ == Source::kFollowed; }
  /// Called, on a thread of its own, when the clock that is followed goes on. Once, at first.
  void observe(std::function<void()> observer);

  /// A step has ended.
  /// @param sim_time  s since start or reset
  /// @param due       when it was to be, if a clock that is followed said so
  void advance(double sim_time, std::optional<Pace> due);
  /// Simulated time goes on from there [s]; the clock stands still until the next step.
  void restart(double sim_time);
  /// Publishes /clock unchanged if it has not been published for a while, so that nodes which
  /// come while the simulation is paused know the time.
  void repeat();

  /// When the last step (or reset) ended.
  ros::Time stamp() const;
  /// Between steps, wall time goes on and simulated time does not.
  ros::Time now() const;

 private:
  void set(const ros::Time& stamp);

  void follow(const rosgraph_msgs::Clock& message);

  const Source source_;
  ros::Publisher publisher_;
  std::function<void()> observer_;
  std::atomic<std::int64_t> followed_{0};  ///< ns; 0 = nothing has come
  ros::Time start_;                        ///< the clock when simulated time was 0
  std::chrono::steady_clock::time_point published_;
  mutable std::mutex mutex_;  ///< of stamp_, which all threads read
  ros::Time stamp_;
  // Last, so that it ends before what it uses: services wait for steps, and steps for this.
  ros::CallbackQueue queue_;
  ros::AsyncSpinner spinner_{1, &queue_};
  ros::Subscriber subscriber_;
};

}  // namespace mass_spring
