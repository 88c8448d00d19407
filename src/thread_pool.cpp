#include "thread_pool.h"

#if defined(__x86_64__) || defined(__i386__)
#include <immintrin.h>
#endif

namespace mass_spring {
namespace {

// Some 50 us of spinning: longer than the gaps within a step, and five times what a wake-up costs.
constexpr int kSpins = 1500;

void relax() {
#if defined(__x86_64__) || defined(__i386__)
  _mm_pause();
#endif
}

}  // namespace

ThreadPool::ThreadPool(std::uint32_t threads) : size_(threads) {
  for (std::uint32_t t = 1; t < size_; ++t) {
    helpers_.emplace_back([this, t] { help(t); });
  }
}

ThreadPool::~ThreadPool() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
    ++issued_;
  }
  wake_.notify_all();
  for (std::thread& helper : helpers_) helper.join();
}

void ThreadPool::doParts(std::uint32_t thread) const {
  for (std::uint32_t part = thread; part < job_.parts; part += size_) {
    job_.function(job_.context, part);
  }
}

void ThreadPool::share(const Job& job) {
  job_ = job;
  unfinished_.store(size_ - 1, std::memory_order_relaxed);
  // Sequentially consistent, as are the helpers' accesses before they sleep: either the helper sees
  // the job, or this thread sees the sleeper.
  ++issued_;
  if (asleep_ > 0) {
    { const std::lock_guard<std::mutex> lock(mutex_); }
    wake_.notify_all();
  }
  doParts(0);
  for (int spin = 0; unfinished_.load(std::memory_order_acquire) > 0; ++spin) {
    // On a busy machine the helper may be waiting for this very core.
    if (spin < kSpins) {
      relax();
    } else {
      std::this_thread::yield();
    }
  }
}

void ThreadPool::awaitJob(std::uint32_t done) {
  for (int spin = 0; spin < kSpins; ++spin) {
    if (issued_.load(std::memory_order_acquire) != done) return;
    relax();
  }
  std::unique_lock<std::mutex> lock(mutex_);
  ++asleep_;
  wake_.wait(lock, [&] { return issued_ != done; });
  --asleep_;
}

void ThreadPool::help(std::uint32_t thread) {
  for (std::uint32_t done = 0;; ++done) {
    awaitJob(done);
    if (ending_) return;
    doParts(thread);
    unfinished_.fetch_sub(1, std::memory_order_release);
  }
}

}  // namespace mass_spring
