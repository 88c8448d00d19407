#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

namespace mass_spring {

/// The threads of one simulation: the caller and helpers that live as long as the pool. Work comes
/// in numbered parts; whoever is free takes the next one, so that the caller waits for no helper
/// that a busy machine has not let begin. What a part computes must not depend on who does it.
/// Helpers spin for the next work, as the gaps within a step are shorter than it takes to wake a
/// thread, but not for long: between the steps they sleep.
class ThreadPool {
 public:
  /// @param threads  >= 1, the caller's included
  explicit ThreadPool(std::uint32_t threads);
  static constexpr std::uint32_t kMaxParts = 0xffff;
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  std::uint32_t size() const { return size_; }

  /// work(part) for each part in [0, parts), in any order and at the same time; returns when all
  /// are done. At most kMaxParts. Not to be called from within work, nor by two threads at once.
  /// The work must not throw.
  template <typename Work>
  void run(std::uint32_t parts, const Work& work) {
    if (size_ == 1 || parts < 2) {
      for (std::uint32_t part = 0; part < parts; ++part) work(part);
      return;
    }
    share({[](const void* context, std::uint32_t part) {
             (*static_cast<const Work*>(context))(part);
           },
           &work},
          parts);
  }

 private:
  struct Job {
    void (*function)(const void* context, std::uint32_t part) = nullptr;
    const void* context = nullptr;
  };
  /// What is still to be taken of the last job, in one word, so that nobody takes of another one:
  /// the number of the job, its parts, and the next part.
  struct Offer {
    std::uint64_t word;
    std::uint32_t job() const { return static_cast<std::uint32_t>(word >> 32); }
    std::uint32_t parts() const { return word >> 16 & kMaxParts; }
    std::uint32_t next() const { return word & kMaxParts; }
    bool any() const { return next() < parts(); }
  };
  void share(const Job& job, std::uint32_t parts);
  void takeParts();
  void help();
  void awaitOffer();

  const std::uint32_t size_;
  Job job_;                                   // written while no part of it is taken
  std::atomic<std::uint64_t> offer_{0};       // an Offer
  std::atomic<std::uint32_t> unfinished_{0};  // parts
  std::atomic<std::uint32_t> asleep_{0};
  std::atomic<bool> ending_{false};
  std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<std::thread> helpers_;
};

}  // namespace mass_spring
