#include "frame_motion.h"

#include <algorithm>

namespace mass_spring {

namespace {

constexpr double kLongest = 0.2;  // s

// Faster is a jump. No arm and no hand moves so fast; a frame that is put elsewhere does.
constexpr FrameMotion::Speeds kFastest{10.0, 30.0};

// In pursuit of a frame that jumped or came back.
constexpr FrameMotion::Speeds kCatchUp{1.0, 2.0};

// tf interpolates and chains transforms: a frame that stands still comes with errors of some 1e-16
// of its coordinates, each time another one.
constexpr double kRounding = 1e-12;

// What is left of the way after whole steps may be a step but for its rounding.
constexpr double kSameTime = 1e-9;

bool standsStill(const Pose& a, const Pose& b) {
  // A quaternion and its negative are the same rotation.
  const double sign = a.orientation.dot(b.orientation) < 0.0 ? -1.0 : 1.0;
  return (a.position - b.position).norm() <= kRounding * std::max(1.0, a.position.norm()) &&
         (a.orientation.coeffs() - sign * b.orientation.coeffs()).norm() <= kRounding;
}

Pose between(const Pose& from, const Pose& to, double share) {
  return {from.position + share * (to.position - from.position),
          from.orientation.slerp(share, to.orientation).normalized()};
}

/// How long the way from one to the other takes at the lower of these speeds [s].
double duration(const Pose& from, const Pose& to, const FrameMotion::Speeds& a,
                const FrameMotion::Speeds& b) {
  return std::max((to.position - from.position).norm() / std::min(a.along, b.along),
                  from.orientation.angularDistance(to.orientation) / std::min(a.turn, b.turn));
}

}  // namespace

Pose FrameMotion::follow(const Pose& heard, const ros::Time& stamp, const ros::Time& now,
                         double step, const Speeds& limit) {
  if (!known_ || !standsStill(there_, heard)) there_ = heard;
  if (stamp != stamp_) {
    const double between_stamps = stamp_.isZero() ? 0.0 : (stamp - stamp_).toSec();
    duration_ = between_stamps <= kLongest ? between_stamps : 0.0;
    start_ = last_;
    begin_ = asked_;  // since then the steps have missed it
    stamp_ = stamp;
  }
  Pose next = known_ ? evenly(now) : there_;
  if (known_ && duration(last_, next, kFastest, limit) > step) behind_ = true;
  if (known_ && behind_) {
    const double left = duration(last_, there_, kCatchUp, limit);
    behind_ = left > (1.0 + kSameTime) * step;
    next = behind_ ? between(last_, there_, step / left) : there_;
    duration_ = 0.0;  // what is left of the even motion began elsewhere
  }
  known_ = true;
  asked_ = now;
  last_ = next;
  return next;
}

Pose FrameMotion::evenly(const ros::Time& now) const {
  const double passed = (now - begin_).toSec();
  if (passed < 0.0 || passed >= duration_ || standsStill(last_, there_)) return there_;
  return between(start_, there_, passed / duration_);
}

}  // namespace mass_spring
