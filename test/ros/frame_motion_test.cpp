#include "ros/frame_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace mass_spring {
namespace {

Pose at(double x, double turn = 0.0) {
  return {{x, 0.0, 0.0}, Eigen::Quaterniond(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()))};
}

constexpr double kStep = 0.02;                       // s
constexpr FrameMotion::Speeds kUnlimited{1e3, 1e3};  // m/s, rad/s
// m. Between FrameMotion's own 1e-12, by which a frame may move unnoticed, and motions on purpose.
constexpr double kExact = 1e-11;

Pose follow(FrameMotion& motion, const Pose& heard, double stamp, double now,
            const FrameMotion::Speeds& limit = kUnlimited) {
  return motion.follow(heard, ros::Time(stamp), ros::Time(now), kStep, limit);
}

bool sameBits(const Pose& a, const Pose& b) {
  return a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs();
}

/// Where steps find a frame that is heard of with each `every`th of them, 0.1 m further.
std::vector<double> placesOf(int every, int steps) {
  FrameMotion motion;
  std::vector<double> places;
  for (int n = 0; n < steps; ++n) {
    const int word = n / every;
    // Stamps are not quite the time at which they come.
    const double stamp = 99.99 + kStep * every * word;
    places.push_back(follow(motion, at(0.1 * word), stamp, 100.0 + kStep * n).position.x());
  }
  return places;
}

TEST(FrameMotion, ArrivesWhenTheNextTransformIsDue) {
  const std::vector<double> places = placesOf(4, 17);
  // The first word, and there is no second one yet.
  for (int n = 0; n < 4; ++n) EXPECT_EQ(places[n], 0.0) << n;
  // Four steps for each 0.1 m. Times of 1e2 s, rounded to 1e-9.
  for (int n = 4; n < 17; ++n) EXPECT_NEAR(places[n], 0.025 * (n - 3), 1e-8) << n;
}

TEST(FrameMotion, LosesNoTimeWhereTransformsComeWithEachStep) {
  const std::vector<double> places = placesOf(1, 6);
  for (int n = 0; n < 6; ++n) EXPECT_DOUBLE_EQ(places[n], 0.1 * n) << n;
}

TEST(FrameMotion, EndsExactlyWhereTheFrameIs) {
  FrameMotion motion;
  follow(motion, at(0.0), 1.0, 1.0);
  follow(motion, at(0.03, 0.02), 1.1, 1.1);
  EXPECT_TRUE(sameBits(follow(motion, at(0.03, 0.02), 1.1, 1.3), at(0.03, 0.02)));
}

TEST(FrameMotion, ArrivesExactlyWhereTransformsComeTooEarly) {
  FrameMotion motion;
  follow(motion, at(0.0), 1.0, 1.0);
  double stamp = 1.0, now = 1.0;
  Pose there;
  // As on a busy machine: each ends the way to the one before at three fifths of it.
  for (int k = 0; k < 60; ++k) {
    stamp += 0.1;
    for (int n = 0; n < 3; ++n) there = follow(motion, at(0.25), stamp, now += kStep);
  }
  EXPECT_TRUE(sameBits(there, at(0.25))) << 0.25 - there.position.x();
}

TEST(FrameMotion, StandsStillWithAFrameThatStandsStill) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  const auto turned = [&] {
    return Eigen::Quaterniond(number(random), number(random), number(random), number(random))
        .normalized();
  };
  for (int k = 0; k < 200; ++k) {
    const Pose pose{{10.0 * number(random), 10.0 * number(random), 10.0 * number(random)},
                    turned()};
    FrameMotion motion;
    double stamp = 1.0, now = 1.0;
    const Pose first = follow(motion, pose, stamp, now);
    for (int n = 0; n < 50; ++n) {
      now += 0.05 + 0.04 * number(random);
      if (n % 3 == 0) stamp = now - 0.01;
      // As tf interpolates between two transforms that are equal, and chains others: rounded
      // otherwise each time. A rotation may come as the negative quaternion.
      const double share = 0.5 + 0.5 * number(random);
      Pose heard{(1.0 - share) * pose.position + share * pose.position,
                 pose.orientation.slerp(share, pose.orientation)};
      heard.position = turned() * heard.position;
      heard.position =
          pose.position + (heard.position.norm() - pose.position.norm()) * Eigen::Vector3d::UnitX();
      if (n % 5 == 0) heard.orientation.coeffs() *= -1.0;
      ASSERT_TRUE(sameBits(follow(motion, heard, stamp, now), first)) << k << ' ' << n;
    }
  }
}

TEST(FrameMotion, TurnsEvenly) {
  FrameMotion motion;
  follow(motion, at(0.0), 1.0, 1.0);
  const Pose half = follow(motion, at(0.0, 0.8), 1.1, 1.05);
  // Twice the arc cosine of a number that is 1 but for its rounding: a root of that.
  EXPECT_NEAR(half.orientation.angularDistance(at(0.0, 0.4).orientation), 0.0, 1e-7);
}

/// Steps until it is at x; checks that none is faster than `fastest` [m/s].
int stepsTo(FrameMotion& motion, double x, double fastest, double& now, double& place,
            const FrameMotion::Speeds& limit = kUnlimited) {
  int steps = 0;
  const double stamp = now;
  while (place != x && steps < 10000) {
    now += 0.001;
    const double next = follow(motion, at(x), stamp, now, limit).position.x();
    // A step that is the last one may be longer by 1e-9 of it.
    EXPECT_LE(std::abs(next - place), fastest * kStep * (1.0 + 1e-9) + 1e-14);
    EXPECT_LE(std::abs(x - next), std::abs(x - place));
    place = next;
    ++steps;
  }
  return steps;
}

TEST(FrameMotion, CatchesUpWithAFrameThatCameBack) {
  FrameMotion motion;
  double now = 1.0, place = follow(motion, at(0.0), now, now).position.x();
  motion.lose();
  now = 5.0;
  // 0.1 m could be done in a step otherwise. At 1 m/s, five steps.
  EXPECT_EQ(stepsTo(motion, 0.1, 1.0, now, place), 5);
  // As before: 0.1 m within a step of 0.02 s is 5 m/s.
  now += 1.0;
  EXPECT_EQ(stepsTo(motion, 0.2, 5.0, now, place), 1);
}

TEST(FrameMotion, CatchesUpWithAFrameThatJumps) {
  // Long silence, no silence, time that jumps back, for ever.
  for (const double stamp : {2.0, 1.05, 0.5, 0.0}) {
    FrameMotion motion;
    double now = 1.0, place = follow(motion, at(0.0), now, now).position.x();
    now = 1.5;
    const double next = follow(motion, at(1.0), stamp, now).position.x();
    EXPECT_NEAR(next, 1.0 * kStep, kExact) << stamp;
    place = next;
    EXPECT_EQ(stepsTo(motion, 1.0, 1.0, now, place), 49) << stamp;
  }
}

TEST(FrameMotion, CatchesUpWithATurn) {
  FrameMotion motion;
  follow(motion, at(0.0), 1.0, 1.0);
  const Pose turned = follow(motion, at(0.0, 1.5), 2.0, 2.0);
  // 2 rad/s; see TurnsEvenly.
  EXPECT_NEAR(turned.orientation.angularDistance(at(0.0).orientation), 2.0 * kStep, 1e-7);
}

TEST(FrameMotion, IsNeverFasterThanItsLimit) {
  FrameMotion motion;
  double now = 1.0, place = follow(motion, at(0.0), now, now).position.x();
  EXPECT_EQ(stepsTo(motion, 0.5, 0.25, now, place, {0.25, 1.0}), 100);
}

}  // namespace
}  // namespace mass_spring
