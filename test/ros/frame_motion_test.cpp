#include "ros/frame_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace mass_spring {
namespace {

Pose at(double x, double turn = 0.0) {
  return {{x, 0.0, 0.0}, Eigen::Quaterniond(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()))};
}

/// Where steps of 0.02 s find a frame that is heard of with each `every`th of them, 0.1 m further.
std::vector<double> follow(int every, int steps) {
  FrameMotion motion;
  std::vector<double> places;
  for (int n = 0; n < steps; ++n) {
    const int word = n / every;
    // Stamps are not quite the time at which they come.
    const ros::Time stamp(99.99 + 0.02 * every * word);
    places.push_back(
        motion.follow(at(0.1 * word), stamp, ros::Time(100.0 + 0.02 * n)).position.x());
  }
  return places;
}

TEST(FrameMotion, ArrivesWhenTheNextTransformIsDue) {
  const std::vector<double> places = follow(4, 17);
  // The first word, and there is no second one yet.
  for (int n = 0; n < 4; ++n) EXPECT_EQ(places[n], 0.0) << n;
  // Four steps for each 0.1 m. Times of 1e2 s, rounded to 1e-9.
  for (int n = 4; n < 17; ++n) EXPECT_NEAR(places[n], 0.025 * (n - 3), 1e-8) << n;
}

TEST(FrameMotion, LosesNoTimeWhereTransformsComeWithEachStep) {
  const std::vector<double> places = follow(1, 6);
  for (int n = 0; n < 6; ++n) EXPECT_DOUBLE_EQ(places[n], 0.1 * n) << n;
}

TEST(FrameMotion, StandsExactlyWhereTheFrameStands) {
  FrameMotion motion;
  motion.follow(at(0.0), ros::Time(1.0), ros::Time(1.0));
  motion.follow(at(0.3, 0.2), ros::Time(1.1), ros::Time(1.1));
  const Pose last = motion.follow(at(0.3, 0.2), ros::Time(1.1), ros::Time(1.3));
  EXPECT_EQ(last.position, at(0.3, 0.2).position);
  EXPECT_EQ(last.orientation.coeffs(), at(0.3, 0.2).orientation.coeffs());
}

TEST(FrameMotion, TurnsEvenly) {
  FrameMotion motion;
  motion.follow(at(0.0), ros::Time(1.0), ros::Time(1.0));
  const Pose half = motion.follow(at(0.0, 0.8), ros::Time(1.1), ros::Time(1.05));
  // Twice the arc cosine of a number that is 1 but for its rounding: a root of that.
  EXPECT_NEAR(half.orientation.angularDistance(at(0.0, 0.4).orientation), 0.0, 1e-7);
  const Pose again = motion.follow(at(0.0, 0.8), ros::Time(1.1), ros::Time(1.05));
  EXPECT_EQ(again.orientation.coeffs(), half.orientation.coeffs());
}

TEST(FrameMotion, IsThereAtOnceAfterLongSilenceAndJumpsOfTime) {
  for (const double stamp : {2.0, 0.5, 0.0}) {
    FrameMotion motion;
    motion.follow(at(0.0), ros::Time(1.0), ros::Time(1.0));
    EXPECT_EQ(motion.follow(at(1.0), ros::Time(stamp), ros::Time(1.01)).position.x(), 1.0) << stamp;
  }
}

}  // namespace
}  // namespace mass_spring
