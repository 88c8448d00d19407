#include "frames.h"

#include <utility>

namespace mass_spring {

Frames::Frames(std::string frame_id)
    : frame_id_(std::move(frame_id)),
      listener_(buffer_, true, ros::TransportHints().tcpNoDelay()) {}

Frames::Placed Frames::find(const std::string& frame_id) const {
  Placed placed{Eigen::Isometry3d::Identity(), ros::Time(0)};
  if (frame_id.empty() || frame_id == frame_id_) return placed;
  const auto found = buffer_.lookupTransform(frame_id_, frame_id, ros::Time(0));
  const auto& translation = found.transform.translation;
  const auto& rotation = found.transform.rotation;
  placed.pose.translate(Eigen::Vector3d(translation.x, translation.y, translation.z));
  placed.pose.rotate(Eigen::Quaterniond(rotation.w, rotation.x, rotation.y, rotation.z));
  placed.stamp = found.header.stamp;
  return placed;
}

}  // namespace mass_spring
