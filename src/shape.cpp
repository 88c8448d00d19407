#include "mass_spring_sim/shape.h"

#include <algorithm>
#include <cmath>

#include "scene/object_parts.h"

namespace mass_spring {
namespace {

/// Takes the z axis to the direction: the shortest turn up to a right angle, beyond it the one to
/// the opposite direction after a half turn about x.
Eigen::Matrix3d zTo(const Eigen::Vector3d& direction) {
  const bool down = direction.z() < 0.0;
  const Eigen::Vector3d n = (down ? -1.0 : 1.0) * direction.normalized();
  Eigen::Quaterniond turn;
  turn.w() = std::sqrt(0.5 * (1.0 + n.z()));  // cosine of half the angle
  turn.vec() = Eigen::Vector3d::UnitZ().cross(n) / (2.0 * turn.w());
  if (down) turn = turn * Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0);
  return turn.toRotationMatrix();
}

/// The distance to a place is |d|, d from there to the point.
Surface around(const Eigen::Vector3d& d, double radius, const Eigen::Matrix3d& free_directions) {
  const double length = d.norm();
  if (length == 0.0) return {-radius, Eigen::Vector3d::UnitX(), Eigen::Matrix3d::Zero()};
  const Eigen::Vector3d n = d / length;
  return {length - radius, n, (free_directions - n * n.transpose()) / length};
}

}  // namespace

Shape::Shape(const ContactShape& shape) : name_(shape.name) {
  std::visit([this](const auto& geometry) { take(geometry); }, shape.geometry);
}

void Shape::take(const Plane& plane) {
  geometry_ = HalfSpace{};
  start_.position = plane.point;
  turn_ = zTo(plane.normal);
}

void Shape::take(const Sphere& sphere) {
  geometry_ = Ball{sphere.radius};
  start_.position = sphere.center;
}

void Shape::take(const Box& box) {
  geometry_ = Cuboid{0.5 * box.size};
  start_.position = box.center;
  start_.orientation = rotation(box.orientation);
}

void Shape::take(const Capsule& capsule) {
  const Eigen::Vector3d axis = capsule.end - capsule.start;
  geometry_ = Rod{0.5 * axis.norm(), capsule.radius};
  start_.position = 0.5 * (capsule.start + capsule.end);
  turn_ = zTo(axis);
}

bool Shape::operator==(const Shape& other) const {
  return name_ == other.name_ && geometry_ == other.geometry_ && turn_ == other.turn_ &&
         start_.position == other.start_.position &&
         start_.orientation.coeffs() == other.start_.orientation.coeffs();
}

std::optional<double> Shape::radius() const {
  return std::visit([](const auto& geometry) { return radius(geometry); }, geometry_);
}

double Shape::distance(const HalfSpace& /*half_space*/, const Eigen::Vector3d& p) { return p.z(); }

double Shape::distance(const Ball& ball, const Eigen::Vector3d& p) {
  return p.norm() - ball.radius;
}

double Shape::distance(const Cuboid& cuboid, const Eigen::Vector3d& p) {
  const Eigen::Vector3d beyond = p.cwiseAbs() - cuboid.half;
  const double deepest = beyond.maxCoeff();
  return deepest > 0.0 ? beyond.cwiseMax(0.0).norm() : deepest;
}

double Shape::distance(const Rod& rod, const Eigen::Vector3d& p) {
  const double along = std::clamp(p.z(), -rod.half, rod.half);
  return Eigen::Vector3d(p.x(), p.y(), p.z() - along).norm() - rod.radius;
}

Surface Shape::surface(const HalfSpace& /*half_space*/, const Eigen::Vector3d& p) {
  return {p.z(), Eigen::Vector3d::UnitZ(), Eigen::Matrix3d::Zero()};
}

Surface Shape::surface(const Ball& ball, const Eigen::Vector3d& p) {
  return around(p, ball.radius, Eigen::Matrix3d::Identity());
}

Surface Shape::surface(const Cuboid& cuboid, const Eigen::Vector3d& p) {
  const Eigen::Vector3d beyond = p.cwiseAbs() - cuboid.half;
  Eigen::Index axis = 0;
  const double deepest = beyond.maxCoeff(&axis);
  if (deepest > 0.0) {
    const Eigen::Vector3d nearest = p.cwiseMax(-cuboid.half).cwiseMin(cuboid.half);
    const Eigen::Vector3d free_directions = (beyond.array() > 0.0).cast<double>();
    return around(p - nearest, 0.0, free_directions.asDiagonal());
  }
  return {deepest, std::copysign(1.0, p[axis]) * Eigen::Vector3d::Unit(axis),
          Eigen::Matrix3d::Zero()};
}

Surface Shape::surface(const Rod& rod, const Eigen::Vector3d& p) {
  const double along = std::clamp(p.z(), -rod.half, rod.half);
  const bool beside = along == p.z();
  const Eigen::Vector3d free_directions(1.0, 1.0, beside ? 0.0 : 1.0);
  return around(p - Eigen::Vector3d(0.0, 0.0, along), rod.radius, free_directions.asDiagonal());
}

PlacedShape::PlacedShape(const Shape& shape, const RigidMotion& motion, double time)
    : shape_(&shape),
      motion_(&motion),
      pose_(motion.at(time)),
      geometry_pose_(Eigen::Isometry3d::Identity()),
      moves_(motion.lasts(time)) {
  geometry_pose_.translation() = pose_.position;
  geometry_pose_.linear() = pose_.orientation.toRotationMatrix() * shape.turn_;
}

Eigen::Vector3d PlacedShape::velocityAt(const Eigen::Vector3d& point) const {
  if (!moves_) return Eigen::Vector3d::Zero();
  return motion_->velocity() + motion_->spin().cross(point - pose_.position);
}

Eigen::Vector3d PlacedShape::spin() const {
  if (!moves_) return Eigen::Vector3d::Zero();
  return motion_->spin();
}

double PlacedShape::distance(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d p = inGeometry(point);
  return std::visit([&p](const auto& geometry) { return Shape::distance(geometry, p); },
                    shape_->geometry_);
}

Surface PlacedShape::at(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d p = inGeometry(point);
  Surface surface = std::visit([&p](const auto& geometry) { return Shape::surface(geometry, p); },
                               shape_->geometry_);
  const Eigen::Matrix3d turn = geometry_pose_.linear();
  surface.normal = turn * surface.normal;
  surface.curvature = turn * surface.curvature * turn.transpose();
  return surface;
}

}  // namespace mass_spring
