#include "shape_markers.h"

#include "surfaces.h"

namespace mass_spring {
namespace {

using visualization_msgs::Marker;

constexpr double kPlaneSize = 4.0;  // m
// A plane is nearly as pale as the background, so that everything else stands out from it.
const Eigen::Vector3d kPlaneColor(0.84, 0.86, 0.89), kShapeColor(0.85, 0.72, 0.58);

/// @param size  m, along the axes of the pose
Marker marker(int type, const Eigen::Isometry3d& pose, const Eigen::Vector3d& size) {
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
  marker.color = toColor(kShapeColor, 1.0);
  return marker;
}

/// The rectangle with this center and these edges, in the light of surfaces: RViz's own light comes
/// from the camera and leaves level faces dark.
void appendRectangle(const Eigen::Isometry3d& pose, const Eigen::Vector3d& center,
                     const Eigen::Vector3d& u, const Eigen::Vector3d& v,
                     const Eigen::Vector3d& color, Marker& out_marker) {
  for (const auto& corner :
       {Eigen::Vector2d(-1, -1), Eigen::Vector2d(1, -1), Eigen::Vector2d(1, 1),
        Eigen::Vector2d(-1, -1), Eigen::Vector2d(1, 1), Eigen::Vector2d(-1, 1)}) {
    out_marker.points.push_back(toPoint(center + 0.5 * (corner.x() * u + corner.y() * v)));
  }
  const Eigen::Vector3d normal = pose.linear() * u.cross(v).normalized();
  out_marker.colors.insert(out_marker.colors.end(), 2, toColor(lit(color, normal), 1.0));
}

/// In the frame that Shape gives the geometry.
struct Draw {
  const Eigen::Isometry3d& pose;

  std::vector<Marker> operator()(const Plane&) const {
    Marker square = marker(Marker::TRIANGLE_LIST, pose, Eigen::Vector3d::Ones());
    appendRectangle(pose, Eigen::Vector3d::Zero(), kPlaneSize * Eigen::Vector3d::UnitX(),
                    kPlaneSize * Eigen::Vector3d::UnitY(), kPlaneColor, square);
    return {square};
  }
  std::vector<Marker> operator()(const Sphere& sphere) const {
    return {marker(Marker::SPHERE, pose, Eigen::Vector3d::Constant(2.0 * sphere.radius))};
  }
  std::vector<Marker> operator()(const Box& box) const {
    Marker faces = marker(Marker::TRIANGLE_LIST, pose, Eigen::Vector3d::Ones());
    const Eigen::Matrix3d edges = box.size.asDiagonal();
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d u = edges.col((axis + 1) % 3), v = edges.col((axis + 2) % 3);
      appendRectangle(pose, 0.5 * edges.col(axis), u, v, kShapeColor, faces);
      appendRectangle(pose, -0.5 * edges.col(axis), v, u, kShapeColor, faces);
    }
    return {faces};
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
