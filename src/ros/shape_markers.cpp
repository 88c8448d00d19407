#include "shape_markers.h"

#include "surfaces.h"

namespace mass_spring {
namespace {

using visualization_msgs::Marker;

constexpr double kPlaneSize = 4.0, kPlaneThickness = 0.002;  // m
// A plane is as pale as the background, so that everything else stands out from it.
const std_msgs::ColorRGBA kPlaneColor = toColor({0.93, 0.94, 0.96}, 1.0);
const std_msgs::ColorRGBA kShapeColor = toColor({0.85, 0.72, 0.58}, 1.0);

/// @param size  m, along the axes of the pose
Marker marker(int type, const Eigen::Isometry3d& pose, const Eigen::Vector3d& size,
              const std_msgs::ColorRGBA& color = kShapeColor) {
  Marker marker;
  marker.type = type;
  marker.action = Marker::ADD;
  marker.pose.position.x = pose.translation().x();
  marker.pose.position.y = pose.translation().y();
  marker.pose.position.z = pose.translation().z();
  const Eigen::Quaterniond turn(pose.linear());
  marker.pose.orientation.x = turn.x();
  marker.pose.orientation.y = turn.y();
  marker.pose.orientation.z = turn.z();
  marker.pose.orientation.w = turn.w();
  marker.scale.x = size.x();
  marker.scale.y = size.y();
  marker.scale.z = size.z();
  marker.color = color;
  return marker;
}

/// In the frame that Shape gives the geometry.
struct Draw {
  const Eigen::Isometry3d& pose;

  std::vector<Marker> operator()(const Plane&) const {
    const Eigen::Isometry3d below = pose * Eigen::Translation3d(0.0, 0.0, -0.5 * kPlaneThickness);
    return {marker(Marker::CUBE, below, {kPlaneSize, kPlaneSize, kPlaneThickness}, kPlaneColor)};
  }
  std::vector<Marker> operator()(const Sphere& sphere) const {
    return {marker(Marker::SPHERE, pose, Eigen::Vector3d::Constant(2.0 * sphere.radius))};
  }
  std::vector<Marker> operator()(const Box& box) const {
    return {marker(Marker::CUBE, pose, box.size)};
  }
  std::vector<Marker> operator()(const Capsule& capsule) const {
    const double length = (capsule.end - capsule.start).norm(), wide = 2.0 * capsule.radius;
    std::vector<Marker> markers = {marker(Marker::CYLINDER, pose, {wide, wide, length})};
    for (const double end : {-0.5 * length, 0.5 * length}) {
      markers.push_back(marker(Marker::SPHERE, pose * Eigen::Translation3d(0.0, 0.0, end),
                               Eigen::Vector3d::Constant(wide)));
    }
    return markers;
  }
};

}  // namespace

std::vector<Marker> shapeMarkers(const Scene& scene, const std::vector<Eigen::Isometry3d>& poses,
                                 const ros::Time& stamp) {
  std::vector<Marker> markers;
  if (!scene.effects.contact) return markers;
  for (std::size_t s = 0; s < poses.size(); ++s) {
    const ContactShape& shape = scene.effects.contact->shapes[s];
    int id = 0;
    for (Marker& marker : std::visit(Draw{poses[s]}, shape.geometry)) {
      marker.header.frame_id = scene.frame_id;
      marker.header.stamp = stamp;
      marker.ns = "contact/" + shape.name;
      marker.id = id++;
      markers.push_back(std::move(marker));
    }
  }
  return markers;
}

}  // namespace mass_spring
