#include "frame_motion.h"

namespace mass_spring {

namespace {

constexpr double kLongest = 0.2;  // s

}  // namespace

Pose FrameMotion::follow(const Pose& heard, const ros::Time& stamp, const ros::Time& now) {
  if (stamp != stamp_) {
    const double between = stamp_.isZero() ? 0.0 : (stamp - stamp_).toSec();
    duration_ = between <= kLongest ? between : 0.0;
    start_ = last_;
    begin_ = asked_;  // since then the steps have missed it
    stamp_ = stamp;
  }
  asked_ = now;
  const double passed = (now - begin_).toSec();
  if (passed >= 0.0 && passed < duration_) {
    const double share = passed / duration_;
    last_.position = start_.position + share * (heard.position - start_.position);
    last_.orientation = start_.orientation.slerp(share, heard.orientation).normalized();
  } else {
    last_ = heard;
  }
  return last_;
}

}  // namespace mass_spring
