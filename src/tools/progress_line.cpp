#include "tools/progress_line.h"

#include <unistd.h>

#include <cstdio>

namespace mass_spring {
namespace {

constexpr std::chrono::milliseconds kPeriod{200};
constexpr const char* kEraseLine = "\r\033[K";

}  // namespace

ProgressLine::ProgressLine(std::uint64_t steps, double step_size)
    : terminal_(isatty(STDERR_FILENO) == 1),
      steps_(steps),
      step_size_(step_size),
      start_(Clock::now()),
      next_(start_ + kPeriod) {}

ProgressLine::~ProgressLine() {
  if (shown_) std::fputs(kEraseLine, stderr);
}

void ProgressLine::show(std::uint64_t step) {
  if (!terminal_) return;
  const Clock::time_point now = Clock::now();
  if (now < next_) return;
  next_ = now + kPeriod;
  shown_ = true;
  const double done = static_cast<double>(step);
  const double total = static_cast<double>(steps_);
  const double seconds = std::chrono::duration<double>(now - start_).count();
  std::fprintf(stderr, "%s%5.1f %%  %.6g of %.6g s simulated, %.3g x real time, %.0f s left",
               kEraseLine, 100.0 * done / total, done * step_size_, total * step_size_,
               done * step_size_ / seconds, seconds * (total - done) / done);
}

}  // namespace mass_spring
