#include "mass_spring_sim/rigid_motion.h"

namespace mass_spring {
namespace {

// A step that ends where the motion does may name that time with another rounding.
constexpr double kSameTime = 1e-9;  // of the duration

}  // namespace

RigidMotion::RigidMotion(const Pose& pose) : from_(pose), to_(pose) {}

RigidMotion::RigidMotion(const Pose& from, const Pose& to, double begin, double duration)
    : from_(from), to_(to), begin_(begin), duration_(duration) {
  velocity_ = (to.position - from.position) / duration;
  Eigen::Quaterniond turn = to.orientation * from.orientation.conjugate();
  if (turn.w() < 0.0) turn.coeffs() *= -1.0;
  const Eigen::AngleAxisd about(turn);
  spin_ = about.angle() / duration * about.axis();
}

bool RigidMotion::lasts(double time) const {
  return duration_ > 0.0 && time <= begin_ + (1.0 + kSameTime) * duration_;
}

bool RigidMotion::operator==(const RigidMotion& other) const {
  const auto same = [](const Pose& a, const Pose& b) {
    return a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs();
  };
  return same(from_, other.from_) && same(to_, other.to_) && begin_ == other.begin_ &&
         duration_ == other.duration_;
}

Pose RigidMotion::at(double time) const {
  if (duration_ == 0.0 || time >= begin_ + (1.0 - kSameTime) * duration_) return to_;
  if (time <= begin_) return from_;
  const double passed = time - begin_;
  Pose pose = from_;
  pose.position += passed * velocity_;
  const double angle = passed * spin_.norm();
  if (angle > 0.0) {
    pose.orientation = Eigen::AngleAxisd(angle, spin_.normalized()) * from_.orientation;
  }
  return pose;
}

}  // namespace mass_spring
