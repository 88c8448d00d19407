#include "thread_pool.h"

#include <cassert>

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
    helpers_.emplace_back([this] { help(); });
  }
}

ThreadPool::~ThreadPool() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
  }
  wake_.notify_all();
  for (std::thread& helper : helpers_) helper.join();
}

void ThreadPool::takeParts() {
  Offer offer{offer_.load(std::memory_order_acquire)};
  while (offer.any()) {
    if (!offer_.compare_exchange_weak(offer.word, offer.word + 1, std::memory_order_acquire)) {
      continue;
    }
    // Until it is finished, there is no other job.
    job_.function(job_.context, offer.next());
    unfinished_.fetch_sub(1, std::memory_order_release);
    offer.word = offer_.load(std::memory_order_acquire);
  }
}

void ThreadPool::share(const Job& job, std::uint32_t parts) {
  assert(parts <= kMaxParts);
  job_ = job;
  unfinished_.store(parts, std::memory_order_relaxed);
  const std::uint64_t number = Offer{offer_.load(std::memory_order_relaxed)}.job() + 1;
  // Sequentially consistent, as are the helpers' accesses before they sleep: either the helper sees
  // the offer, or this thread sees the sleeper.
  offer_ = number << 32 | std::uint64_t{parts} << 16;
  if (asleep_ > 0) {
    { const std::lock_guard<std::mutex> lock(mutex_); }
    wake_.notify_all();
  }
  takeParts();
  for (int spin = 0; unfinished_.load(std::memory_order_acquire) > 0; ++spin) {
    // On a busy machine the helper may be waiting for this very core.
    if (spin < kSpins) {
      relax();
    } else {
      std::this_thread::yield();
    }
  }
}

void ThreadPool::awaitOffer() {
  for (int spin = 0; spin < kSpins; ++spin) {
    if (Offer{offer_.load(std::memory_order_acquire)}.any()) return;
    relax();
  }
  std::unique_lock<std::mutex> lock(mutex_);
  ++asleep_;
  wake_.wait(lock, [&] { return ending_ || Offer{offer_}.any(); });
  --asleep_;
}

void ThreadPool::help() {
  while (!ending_) {
    awaitOffer();
    takeParts();
  }
}

}  // namespace mass_spring
