#pragma once

#include <chrono>
#include <condition_variable>
#include <future>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace mass_spring {

/// Keeps this node known to the master: where that has been started anew, topics and services are
/// registered again, as roscpp does not by itself. Links between nodes need no master and stay.
/// Has a thread of its own, which looks once a second.
class Registration {
 public:
  /// @param services  resolved names of those that this node offers
  explicit Registration(std::vector<std::string> services);
  ~Registration();

  /// Asks the thread to end. @return false if it waits for the master longer than patience
  bool stop(std::chrono::milliseconds patience);

 private:
  void run();
  void look();
  void registerAgain() const;

  const std::vector<std::string> services_;
  bool reached_ = true;  ///< the master answered
  std::mutex mutex_;
  std::condition_variable stopped_;
  bool stopping_ = false;
  std::promise<void> ended_promise_;
  std::future<void> ended_ = ended_promise_.get_future();
  std::thread thread_;
};

}  // namespace mass_spring
