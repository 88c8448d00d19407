#include "command_queue.h"

#include <utility>

namespace mass_spring {

bool CommandQueue::offer(Task command) {
  {
    std::lock_guard lock(mutex_);
    if (closed_ || tasks_.size() >= kCapacity) return false;
    tasks_.push_back(std::move(command));
  }
  arrived_.notify_one();
  return true;
}

void CommandQueue::post(Task request) {
  {
    std::lock_guard lock(mutex_);
    if (closed_) return;
    tasks_.push_back(std::move(request));
  }
  arrived_.notify_one();
}

std::deque<CommandQueue::Task> CommandQueue::take() {
  std::lock_guard lock(mutex_);
  return std::exchange(tasks_, {});
}

void CommandQueue::wait(std::chrono::steady_clock::time_point deadline) {
  std::unique_lock lock(mutex_);
  if (closed_ || woken_ || !tasks_.empty()) {
    woken_ = false;
    return;
  }
  arrived_.wait_until(lock, deadline);
  woken_ = false;
}

void CommandQueue::wake() {
  {
    std::lock_guard lock(mutex_);
    woken_ = true;
  }
  arrived_.notify_one();
}

void CommandQueue::close() {
  std::deque<Task> dropped;  // destroyed without the lock: tasks may own promises that wake others
  {
    std::lock_guard lock(mutex_);
    closed_ = true;
    dropped.swap(tasks_);
  }
  arrived_.notify_all();
}

bool CommandQueue::closed() const {
  std::lock_guard lock(mutex_);
  return closed_;
}

}  // namespace mass_spring
