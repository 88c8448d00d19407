#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

namespace mass_spring {

/// The threads of one simulation: the caller and helpers that live as long as the pool. Work comes
/// in numbered parts, and who does which part is fixed, so that results do not depend on timing.
/// Helpers spin for the next work, as the gaps within a step are shorter than it takes to wake a
/// thread, but not for long: between the steps they sleep.
class ThreadPool {
 public:
  /// @param threads  >= 1, the caller's included
  explicit ThreadPool(std::uint32_t threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  std::uint32_t size() const { return size_; }

  /// work(part) for each part in [0, parts), in any order and at the same time; returns when all
  /// are done. Not to be called from within work, nor by two threads at once. The work must not
  /// throw.
  template <typename Work>
  void run(std::uint32_t parts, const Work& work) {
    if (size_ == 1 || parts < 2) {
      for (std::uint32_t part = 0; part < parts; ++part) work(part);
      return;
    }
    share({[](const void* context, std::uint32_t part) {
             (*static_cast<const Work*>(context))(part);
           },
           &work, parts});
  }

 private:
  struct Job {
    void (*function)(const void* context, std::uint32_t part) = nullptr;
    const void* context = nullptr;
    std::uint32_t parts = 0;
  };
  void share(const Job& job);
  void doParts(std::uint32_t thread) const;
  void help(std::uint32_t thread);
  void awaitJob(std::uint32_t done);

  const std::uint32_t size_;
  Job job_;                                   // written while no helper works
  std::atomic<std::uint32_t> issued_{0};      // jobs so far
  std::atomic<std::uint32_t> unfinished_{0};  // helpers still at the job
  std::atomic<std::uint32_t> asleep_{0};
  std::atomic<bool> ending_{false};
  std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<std::thread> helpers_;
};

}  // namespace mass_spring
