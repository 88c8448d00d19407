#include "tools/study_progress.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace mass_spring {
namespace {

constexpr int kWidth = 24;
constexpr const char* kErase = "\r\033[K";

}  // namespace

StudyProgress::StudyProgress(double time_limit)
    : terminal_(isatty(STDERR_FILENO) == 1), time_limit_(time_limit), start_(Clock::now()) {}

StudyProgress::~StudyProgress() { erase(); }

double StudyProgress::elapsed() const {
  return std::chrono::duration<double>(Clock::now() - start_).count();
}

void StudyProgress::erase() {
  if (terminal_) std::fputs(kErase, stderr);
}

void StudyProgress::show(const std::string& what) {
  if (!terminal_) return;
  const double share = std::clamp(elapsed() / time_limit_, 0.0, 1.0);
  const auto done = static_cast<int>(kWidth * share);
  std::string bar(static_cast<std::size_t>(kWidth), ' ');
  std::fill(bar.begin(), bar.begin() + done, '=');
  std::fprintf(stderr, "%s[%s] at most %.0f s left: %s", kErase, bar.c_str(), std::max(left(), 0.0),
               what.c_str());
  std::fflush(stderr);
}

void StudyProgress::print(const StudyRow& row) {
  erase();
  if (row.usable()) {
    std::printf("%-60s %10.4g mm  %10.4g s  %s\n", describe(row.setting).c_str(),
                1e3 * row.rms_error, row.wall_seconds, row.status.c_str());
  } else {
    std::printf("%-60s %s\n", describe(row.setting).c_str(), row.status.c_str());
  }
  std::fflush(stdout);
}

}  // namespace mass_spring
