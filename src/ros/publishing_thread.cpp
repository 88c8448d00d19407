#include "publishing_thread.h"

#include <ros/console.h>

#include <algorithm>
#include <utility>

#include "throttle.h"

namespace mass_spring {

// Somebody who plots or records wants each state and each event, so a moment's delay must not cost
// one; figures and markers that are late are of no use to anybody.
PublishingThread::PublishingThread(std::size_t max_states)
    : capacities_{10000, max_states, 100, 100, 10, 1, 1}, thread_([this] { run(); }) {}

PublishingThread::~PublishingThread() {
  {
    std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  arrived_.notify_one();
  thread_.join();
}

void PublishingThread::post(Lane lane, Job job) {
  bool dropped = false;
  {
    std::lock_guard lock(mutex_);
    std::deque<Job>& waiting = lanes_[lane];
    if (waiting.size() == capacities_[lane]) {
      waiting.pop_front();
      dropped = true;
    }
    waiting.push_back(std::move(job));
  }
  arrived_.notify_one();
  static Throttle throttle;
  if (dropped && (lane == kEvents || lane == kState) && throttle.ready()) {
    ROS_WARN("Publishing cannot keep up with the simulation: messages are left out.");
  }
}

void PublishingThread::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    const auto lane = std::find_if(lanes_.begin(), lanes_.end(),
                                   [](const std::deque<Job>& jobs) { return !jobs.empty(); });
    if (stopping_) return;
    if (lane == lanes_.end()) {
      arrived_.wait(lock);
      continue;
    }
    Job job = std::move(lane->front());
    lane->pop_front();
    lock.unlock();
    job();
    job = nullptr;  // lets go of its snapshot without the lock
    lock.lock();
  }
}

}  // namespace mass_spring
