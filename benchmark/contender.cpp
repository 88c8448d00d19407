#include "contender.h"

#include <malloc.h>
#include <time.h>

#include <algorithm>
#include <chrono>
#include <limits>

namespace mass_spring {
namespace {

double processorMilliseconds() {
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

}  // namespace

State clockStep(Contender& contender, const State& start, int frame, bool& comparable) {
  State state = start;
  if (contender.prepare) contender.prepare(state);
  const std::size_t heap = heapBytes();
  const double processor = processorMilliseconds();
  const auto begin = std::chrono::steady_clock::now();
  const StepOutcome outcome = contender.step(state);
  const std::chrono::duration<double, std::milli> wall = std::chrono::steady_clock::now() - begin;
  const double used = processorMilliseconds() - processor;
  if (contender.steps++ == 0) contender.bytes += heapBytes() - heap;
  comparable = outcome.comparable;
  if (comparable) {
    contender.samples.push_back({frame, wall.count(), used});
    contender.iterations += outcome.iterations;
  }
  return state;
}

bool hasTime(const Contender& contender, double seconds, int frame, int frames) {
  double spent = 0.0;
  for (const Contender::Sample& sample : contender.samples) spent += 1e-3 * sample.wall;
  return spent * frames <= seconds * frame;
}

std::size_t heapBytes() {
#if __GLIBC_PREREQ(2, 33)
  const auto info = mallinfo2();
#else
  const auto info = mallinfo();  // of 32 bits: right below 2 GB
#endif
  return static_cast<std::size_t>(info.uordblks) + static_cast<std::size_t>(info.hblkhd);
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto rank = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<std::size_t>(rank)];
}

double medianWall(const Contender& contender) {
  std::vector<double> times;
  for (const Contender::Sample& sample : contender.samples) times.push_back(sample.wall);
  return quantile(times, 0.5);
}

double medianRatio(const Contender& slow, const Contender& fast) {
  std::vector<double> ratios;
  for (const Contender::Sample& s : slow.samples) {
    for (const Contender::Sample& f : fast.samples) {
      if (s.frame == f.frame) ratios.push_back(s.wall / f.wall);
    }
  }
  return quantile(ratios, 0.5);
}

}  // namespace mass_spring
