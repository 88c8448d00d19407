#pragma once

#include <array>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace mass_spring {

/// Builds and publishes messages, so that the thread that steps need not. Each kind of message has
/// a lane of its own; when a lane is full its oldest message is dropped, never a step delayed.
class PublishingThread {
 public:
  using Job = std::function<void()>;
  /// In order of precedence.
  enum Lane { kEvents, kState, kPins, kContacts, kStats, kPoints, kMarkers, kLaneCount };

  /// @param max_states  how many jobs may wait in the lane kState
  explicit PublishingThread(std::size_t max_states);
  /// Drops what has not been published.
  ~PublishingThread();

  void post(Lane lane, Job job);

 private:
  void run();

  const std::array<std::size_t, kLaneCount> capacities_;
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::array<std::deque<Job>, kLaneCount> lanes_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace mass_spring
