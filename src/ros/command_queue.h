#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>

namespace mass_spring {

/// Work that waits for the next step boundary, in order of arrival. Any thread puts it in, the
/// thread that steps takes it out.
class CommandQueue {
 public:
  using Task = std::function<void()>;

  /// As many commands may wait for one boundary.
  static constexpr std::size_t kCapacity = 10000;

  /// Adds a command. @return false if the queue is full or closed
  bool offer(Task command);
  /// Adds what a service asked for; services are answered one by one, so that they need no bound.
  /// Dropped if the queue is closed.
  void post(Task request);

  /// Everything that waits, and leaves the queue empty.
  std::deque<Task> take();
  /// Lets wait() return.
  void wake();
  /// Returns when something waits, the queue is closed, at the deadline, or for no reason.
  void wait(std::chrono::steady_clock::time_point deadline);

  /// From now on nothing gets in; drops what waits.
  void close();
  bool closed() const;

 private:
  mutable std::mutex mutex_;
  std::condition_variable arrived_;
  std::deque<Task> tasks_;
  bool closed_ = false;
  bool woken_ = false;
};

}  // namespace mass_spring
