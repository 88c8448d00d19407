#include "frames.h"

#include <utility>

namespace mass_spring {

Frames::Frames(std::string frame_id)
    : frame_id_(std::move(frame_id)),
      listener_(buffer_, true, ros::TransportHints().tcpNoDelay()) {}

Frames::Placed Frames::find(const std::string& frame_id) const {
  Placed placed{Eigen::Isometry3d::Identity(), ros::Time(0)};
  if (frame_id.empty() || frame_id == frame_id_) return placed;
  const auto found = lookUp(frame_id);
  const auto& translation = found.transform.translation;
  const auto& rotation = found.transform.rotation;
  placed.pose.translate(Eigen::Vector3d(translation.x, translation.y, translation.z));
  placed.pose.rotate(Eigen::Quaterniond(rotation.w, rotation.x, rotation.y, rotation.z));
  placed.stamp = found.header.stamp;
  return placed;
}

geometry_msgs::TransformStamped Frames::lookUp(const std::string& frame_id) const {
  try {
    return buffer_.lookupTransform(frame_id_, frame_id, ros::Time(0));
  } catch (const tf2::LookupException&) {
    // tf2 names the first of the two that it does not know, which is the scene's as long as nothing
    // has come from tf at all.
    const std::string frame = "the frame \"" + frame_id + "\"";
    const std::string scene = "the scene's frame \"" + frame_id_ + "\"";
    if (buffer_._frameExists(frame_id)) {
      throw tf2::LookupException("tf knows " + frame + ", but not " + scene);
    }
    if (!buffer_._frameExists(frame_id_)) {
      throw tf2::LookupException("tf knows neither " + frame + " nor " + scene);
    }
    throw tf2::LookupException("tf knows no frame \"" + frame_id + "\"; the scene's frame is \"" +
                               frame_id_ + '"');
  }
}

}  // namespace mass_spring
