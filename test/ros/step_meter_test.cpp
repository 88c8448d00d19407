#include "ros/step_meter.h"

#include <gtest/gtest.h>

namespace mass_spring {
namespace {

using std::chrono::milliseconds;

// Quotients of counts and seconds that are exact but for the last bits.
constexpr double kSumRounding = 1e-12;

TEST(StepMeter, MeasuresTheLastSecondOnly) {
  StepMeter meter(0.01);
  const StepMeter::Time start = StepMeter::Time() + std::chrono::hours(1);
  meter.start(start);
  StepMeter::Time now = start;
  // Real time at first, then steps of twice the time: half of real time.
  for (int i = 0; i < 100; ++i) meter.add(now += milliseconds(10), 0.5);
  EXPECT_NEAR(meter.figures(now).real_time_factor, 1.0, kSumRounding);
  for (int i = 0; i < 50; ++i) meter.add(now += milliseconds(20), i == 7 ? 0.004 : 0.002);
  const StepMeter::Figures& figures = meter.figures(now);
  EXPECT_NEAR(figures.real_time_factor, 0.5, kSumRounding);
  EXPECT_EQ(figures.median, 0.002);
  EXPECT_EQ(figures.max, 0.004);
}

TEST(StepMeter, DoesNotTakeAPauseForSlowness) {
  StepMeter meter(0.01);
  StepMeter::Time now = StepMeter::Time() + std::chrono::hours(1);
  meter.start(now);
  for (int i = 0; i < 50; ++i) meter.add(now += milliseconds(10), 0.001);
  now += std::chrono::seconds(30);
  meter.start(now);
  for (int i = 0; i < 20; ++i) meter.add(now += milliseconds(10), 0.001);
  EXPECT_NEAR(meter.figures(now).real_time_factor, 1.0, kSumRounding);
}

}  // namespace
}  // namespace mass_spring
