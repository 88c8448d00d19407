#include "step_meter.h"

#include <algorithm>
#include <vector>

namespace mass_spring {

namespace {

constexpr std::chrono::seconds kWindow(1);
constexpr std::chrono::milliseconds kRefreshPeriod(100);

}  // namespace

void StepMeter::start(Time now) {
  started_ = now;
  measured_ = Time();
  samples_.clear();
}

void StepMeter::add(Time end, double seconds) {
  samples_.push_back({end, seconds});
  while (samples_.front().end <= end - kWindow) samples_.pop_front();
}

const StepMeter::Figures& StepMeter::figures(Time now) {
  if (samples_.empty() || now < measured_ + kRefreshPeriod) return figures_;
  measured_ = now;
  const std::chrono::duration<double> window = std::min<Time::duration>(kWindow, now - started_);
  std::vector<double> seconds;
  seconds.reserve(samples_.size());
  for (const Sample& sample : samples_) seconds.push_back(sample.seconds);
  const auto middle = seconds.begin() + seconds.size() / 2;
  std::nth_element(seconds.begin(), middle, seconds.end());
  figures_.median = *middle;
  figures_.max = *std::max_element(seconds.begin(), seconds.end());
  figures_.real_time_factor = seconds.size() * step_size_ / window.count();
  return figures_;
}

}  // namespace mass_spring
