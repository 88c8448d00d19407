#include "effects/shape.h"

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

Shape::Shape(const ContactShape& shape) : name_(shape.name), motion_(start_) {
  if (const auto* plane = std::get_if<mass_spring::Plane>(&shape.geometry)) {
    geometry_ = Plane{};
    start_.position = plane->point;
    turn_ = zTo(plane->normal);
  } else if (const auto* sphere = std::get_if<mass_spring::Sphere>(&shape.geometry)) {
    geometry_ = Sphere{sphere->radius};
    start_.position = sphere->center;
  } else if (const auto* box = std::get_if<mass_spring::Box>(&shape.geometry)) {
    geometry_ = Box{0.5 * box->size};
    start_.position = box->center;
    start_.orientation = rotation(box->orientation);
  } else {
    const auto& capsule = std::get<mass_spring::Capsule>(shape.geometry);
    const Eigen::Vector3d axis = capsule.end - capsule.start;
    geometry_ = Capsule{0.5 * axis.norm(), capsule.radius};
    start_.position = 0.5 * (capsule.start + capsule.end);
    turn_ = zTo(axis);
  }
  reset();
}

bool Shape::startsLike(const Shape& other) const {
  return name_ == other.name_ && geometry_ == other.geometry_ && turn_ == other.turn_ &&
         start_.position == other.start_.position &&
         start_.orientation.coeffs() == other.start_.orientation.coeffs();
}

void Shape::reset() {
  motion_ = RigidMotion(start_);
  moves_ = false;
  place(start_);
}

void Shape::place(const Pose& pose) {
  pose_ = pose;
  geometry_pose_ = Eigen::Isometry3d::Identity();
  geometry_pose_.translation() = pose.position;
  geometry_pose_.linear() = pose.orientation.toRotationMatrix() * turn_;
}

bool Shape::setTime(double time) {
  moves_ = motion_.lasts(time);
  place(motion_.at(time));
  return moves_;
}

Eigen::Vector3d Shape::velocityAt(const Eigen::Vector3d& point) const {
  if (!moves_) return Eigen::Vector3d::Zero();
  return motion_.velocity() + motion_.spin().cross(point - pose_.position);
}

Eigen::Vector3d Shape::spin() const {
  if (!moves_) return Eigen::Vector3d::Zero();
  return motion_.spin();
}

std::optional<double> Shape::radius() const {
  if (const auto* sphere = std::get_if<Sphere>(&geometry_)) return sphere->radius;
  if (const auto* box = std::get_if<Box>(&geometry_)) return box->half.norm();
  if (const auto* capsule = std::get_if<Capsule>(&geometry_)) {
    return capsule->half + capsule->radius;
  }
  return std::nullopt;
}

double Shape::distance(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d p =
      geometry_pose_.linear().transpose() * (point - geometry_pose_.translation());
  if (std::holds_alternative<Plane>(geometry_)) return p.z();
  if (const auto* sphere = std::get_if<Sphere>(&geometry_)) return p.norm() - sphere->radius;
  if (const auto* box = std::get_if<Box>(&geometry_)) {
    const Eigen::Vector3d beyond = p.cwiseAbs() - box->half;
    const double deepest = beyond.maxCoeff();
    return deepest > 0.0 ? beyond.cwiseMax(0.0).norm() : deepest;
  }
  const auto& capsule = std::get<Capsule>(geometry_);
  const double along = std::clamp(p.z(), -capsule.half, capsule.half);
  return Eigen::Vector3d(p.x(), p.y(), p.z() - along).norm() - capsule.radius;
}

Surface Shape::at(const Eigen::Vector3d& point) const {
  const Eigen::Matrix3d turn = geometry_pose_.linear();
  const Eigen::Vector3d p = turn.transpose() * (point - geometry_pose_.translation());
  Surface surface{p.z(), Eigen::Vector3d::UnitZ(), Eigen::Matrix3d::Zero()};
  if (const auto* sphere = std::get_if<Sphere>(&geometry_)) {
    surface = around(p, sphere->radius, Eigen::Matrix3d::Identity());
  } else if (const auto* box = std::get_if<Box>(&geometry_)) {
    const Eigen::Vector3d beyond = p.cwiseAbs() - box->half;
    Eigen::Index axis = 0;
    const double deepest = beyond.maxCoeff(&axis);
    if (deepest > 0.0) {
      const Eigen::Vector3d nearest = p.cwiseMax(-box->half).cwiseMin(box->half);
      const Eigen::Vector3d free_directions = (beyond.array() > 0.0).cast<double>();
      surface = around(p - nearest, 0.0, free_directions.asDiagonal());
    } else {
      surface.distance = deepest;
      surface.normal = std::copysign(1.0, p[axis]) * Eigen::Vector3d::Unit(axis);
    }
  } else if (const auto* capsule = std::get_if<Capsule>(&geometry_)) {
    const double along = std::clamp(p.z(), -capsule->half, capsule->half);
    const bool beside = along == p.z();
    const Eigen::Vector3d free_directions(1.0, 1.0, beside ? 0.0 : 1.0);
    surface =
        around(p - Eigen::Vector3d(0.0, 0.0, along), capsule->radius, free_directions.asDiagonal());
  }
  surface.normal = turn * surface.normal;
  surface.curvature = turn * surface.curvature * turn.transpose();
  return surface;
}

}  // namespace mass_spring
