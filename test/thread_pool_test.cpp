#include "thread_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <numeric>
#include <thread>

namespace mass_spring {
namespace {

TEST(ThreadPool, DoesEachPartOnce) {
  for (std::uint32_t threads : {1u, 2u, 3u}) {
    ThreadPool pool(threads);
    EXPECT_EQ(pool.size(), threads);
    std::vector<int> done(7, 0);  // each part has its own element
    constexpr int kRounds = 5000;
    for (int round = 0; round < kRounds; ++round) {
      pool.run(static_cast<std::uint32_t>(round) % 8, [&](std::uint32_t part) { ++done[part]; });
    }
    // Part p is there in the rounds of more than p parts.
    for (int part = 0; part < 7; ++part) EXPECT_EQ(done[part], kRounds / 8 * (7 - part)) << part;
  }
}

TEST(ThreadPool, SeesWhatWasWrittenBeforeAndAfter) {
  ThreadPool pool(2);
  std::vector<long> numbers(1000);
  long halves[2];
  for (int round = 1; round <= 200; ++round) {
    std::fill(numbers.begin(), numbers.end(), round);
    pool.run(2, [&](std::uint32_t part) {
      halves[part] =
          std::accumulate(numbers.begin() + 500 * part, numbers.begin() + 500 * (part + 1), 0L);
    });
    ASSERT_EQ(halves[0] + halves[1], 1000L * round);
  }
}

// As a busy machine does, this holds the helper up in the first part that it takes, until the
// caller has done all the others.
TEST(ThreadPool, DoesTheWorkOfAHelperThatIsHeldUp) {
  ThreadPool pool(2);
  const auto caller = std::this_thread::get_id();
  constexpr std::uint32_t kParts = 5;
  for (int round = 0; round < 200; ++round) {
    std::atomic<std::uint32_t> done{0};
    bool waited_in_vain = false;
    pool.run(kParts, [&](std::uint32_t) {
      const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
      while (std::this_thread::get_id() != caller && done + 1 < kParts && !waited_in_vain) {
        std::this_thread::yield();
        waited_in_vain = std::chrono::steady_clock::now() > deadline;
      }
      ++done;
    });
    ASSERT_FALSE(waited_in_vain);
    ASSERT_EQ(done, kParts);
  }
}

// Helpers that have gone to sleep must come back. They do so within the pause, or the test has less
// to find: what it expects holds either way.
TEST(ThreadPool, WakesUp) {
  ThreadPool pool(2);
  for (int round = 0; round < 5; ++round) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    int done[2] = {0, 0};
    pool.run(2, [&](std::uint32_t part) { done[part] = 1; });
    EXPECT_EQ(done[0] + done[1], 2);
  }
}

}  // namespace
}  // namespace mass_spring
