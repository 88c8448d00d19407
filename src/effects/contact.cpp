#include "effects/contact.h"

#include <algorithm>

#include "solvers/step_matrix.h"

namespace mass_spring {
namespace {

SymmetricBlock symmetric(const Eigen::Matrix3d& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)};
}

Eigen::Vector3d across(const Eigen::Vector3d& n, const Eigen::Vector3d& v) {
  return v - n.dot(v) * n;
}

}  // namespace

Contact::Contact(const ContactOptions& options, const Eigen::VectorXd& masses)
    : options_(options),
      friction_(options.friction.value_or(0.0)),
      masses_(masses),
      known_(static_cast<std::size_t>(masses.size()) * options.shapes.size()),
      ends_(3, masses.size()) {
  for (const ContactShape& shape : options.shapes) shapes_.emplace_back(shape);
}

std::vector<std::string> Contact::names() const {
  if (options_.friction) return {"contact", "friction"};
  return {"contact"};
}

template <typename Visit>
void Contact::forEachContact(const Vectors& positions, Visit visit) const {
  for (std::uint32_t i = 0; i < masses_.size(); ++i) {
    const Eigen::Vector3d x = positions.col(i);
    for (std::uint32_t s = 0; s < shapes_.size(); ++s) {
      if (!(shapes_[s].distance(x) < options_.thickness)) continue;
      const Surface surface = shapes_[s].at(x);
      visit(i, s, surface, options_.thickness - surface.distance);
    }
  }
}

Shape* Contact::find(const std::string& name) {
  const auto found = std::find_if(shapes_.begin(), shapes_.end(),
                                  [&](const Shape& shape) { return shape.name() == name; });
  return found == shapes_.end() ? nullptr : &*found;
}

void Contact::reset() {
  for (Shape& shape : shapes_) shape.reset();
}

void Contact::continueFrom(const Contact& other) {
  for (Shape& shape : shapes_) {
    for (const Shape& from : other.shapes_) {
      if (from.startsLike(shape)) shape = from;
    }
  }
}

bool Contact::setTime(double time) {
  bool moves = false;
  for (Shape& shape : shapes_) moves = shape.setTime(time) || moves;
  return moves;
}

Contact::Slip Contact::slip(double speed) const {
  const double e = options_.slip_velocity;
  if (speed < e) return {(2.0 - speed / e) / e, -speed / (e * e)};
  return {1.0 / speed, -1.0 / speed};
}

void Contact::addEnergy(const Vectors& positions, Energy& energy) const {
  forEachContact(positions, [&](auto, auto, const Surface&, double depth) {
    energy.elastic += 0.5 * options_.stiffness * depth * depth;
  });
}

void Contact::addForces(const Vectors& positions, const Vectors& velocities,
                        Vectors& forces) const {
  Energy energy;
  double dissipation = 0.0;
  addForces(positions, velocities, forces, energy, dissipation);
}

void Contact::addForces(const Vectors& positions, const Vectors& velocities, Vectors& forces,
                        Energy& energy, double& dissipation) const {
  addForcesHolding(positions, positions, velocities, forces, energy, dissipation);
}

void Contact::addForcesHolding(const Vectors& held, const Vectors& positions,
                               const Vectors& velocities, Vectors& forces, Energy& energy,
                               double& dissipation) const {
  const double k = options_.stiffness, e = options_.slip_velocity;
  const auto press = [&](std::uint32_t i, const Surface& surface, double depth) {
    energy.elastic += 0.5 * k * depth * depth;
    forces.col(i) += k * depth * surface.normal;
  };
  const auto rub = [&](std::uint32_t i, std::uint32_t s, const Surface& surface, double depth,
                       const Eigen::Vector3d& x) {
    const double limit = friction_ * k * depth;
    const Eigen::Vector3d sliding =
        across(surface.normal, velocities.col(i) - shapes_[s].velocityAt(x));
    const double speed = sliding.norm(), y = speed / e;
    forces.col(i) -= limit * slip(speed).secant * sliding;
    dissipation += limit * e * (y < 1.0 ? y * y * (1.0 - y / 3.0) : y - 1.0 / 3.0);
  };
  const bool apart = &held != &positions;
  forEachContact(positions,
                 [&](std::uint32_t i, std::uint32_t s, const Surface& surface, double depth) {
                   press(i, surface, depth);
                   if (friction_ > 0.0 && !apart) rub(i, s, surface, depth, positions.col(i));
                 });
  if (friction_ == 0.0 || !apart) return;
  forEachContact(held, [&](std::uint32_t i, std::uint32_t s, const Surface& surface, double depth) {
    rub(i, s, surface, depth, held.col(i));
  });
}

// With N = k p, u = v - (n . v) n, v beyond the velocity of the shape: dN = -k n . dx, dn = H dx,
// du = dv across n - (dn . v) n - (n . v) dn, and what dv has along n stays out.
void Contact::addForceDerivative(const Vectors& x, const Vectors& v, const Vectors& dx,
                                 const Vectors& dv, Vectors& df) const {
  forEachContact(x, [&](std::uint32_t i, std::uint32_t s, const Surface& surface, double depth) {
    const Eigen::Vector3d& n = surface.normal;
    const double pressure = options_.stiffness * depth;
    const double more = -options_.stiffness * n.dot(dx.col(i));
    const Eigen::Vector3d dn = surface.curvature * dx.col(i);
    df.col(i) += more * n + pressure * dn;
    if (friction_ == 0.0) return;
    const Eigen::Vector3d slip_v = v.col(i) - shapes_[s].velocityAt(x.col(i));
    const Eigen::Vector3d slip_dv = dv.col(i) - shapes_[s].spin().cross(dx.col(i));
    const Eigen::Vector3d sliding = across(n, slip_v);
    const double speed = sliding.norm();
    const Eigen::Vector3d du = across(n, slip_dv) - dn.dot(slip_v) * n - n.dot(slip_v) * dn;
    const Slip g = slip(speed);
    Eigen::Vector3d change = g.secant * du;
    if (speed > 0.0) {
      const Eigen::Vector3d along = sliding / speed;
      change += g.slope * along.dot(du) * along;
    }
    df.col(i) -= friction_ * (more * g.secant * sliding + pressure * change);
  });
}

std::uint32_t Contact::addDerivatives(const Vectors& positions, const Vectors& velocities,
                                      const MatrixWeights& weights, Projection projection,
                                      StepMatrix& matrix) const {
  std::uint32_t projected = 0;
  const auto add = [&](std::uint32_t i, std::uint32_t s, const Surface& surface, double depth) {
    const Eigen::Vector3d& n = surface.normal;
    const double pressure = options_.stiffness * depth;
    Eigen::Matrix3d block = weights.stiffness * options_.stiffness * n * n.transpose();
    if (projection == Projection::kNone) {
      block -= weights.stiffness * pressure * surface.curvature;
    } else if (weights.stiffness > 0.0 && !surface.curvature.isZero(0.0)) {
      ++projected;
    }
    if (friction_ > 0.0 && weights.damping > 0.0) {
      const Eigen::Vector3d sliding =
          across(n, velocities.col(i) - shapes_[s].velocityAt(positions.col(i)));
      const double speed = sliding.norm();
      const Slip g = slip(speed);
      const double weight = weights.damping * friction_ * pressure;
      block += weight * g.secant * (Eigen::Matrix3d::Identity() - n * n.transpose());
      if (projection == Projection::kNone && speed > 0.0) {
        block += weight * g.slope / (speed * speed) * sliding * sliding.transpose();
      }
    }
    matrix.diagonal()[i] += symmetric(block);
  };
  forEachContact(positions, add);
  return projected;
}

std::uint32_t Contact::linearize(const Vectors& positions, const Vectors& velocities, double w,
                                 StepMatrix& matrix, Vectors& forces) const {
  const double k = options_.stiffness;
  std::uint32_t projected = 0;
  known_.assign(known_.size(), 0);
  for (std::uint32_t i = 0; i < masses_.size(); ++i) {
    for (std::uint32_t s = 0; s < shapes_.size(); ++s) {
      // About the deepest one of where a particle is, where it is to be expected, and where it has
      // just been seen to go: what lies ahead is kept out by this step already, and what is pushed
      // out does not fall back in.
      const Eigen::Vector3d x = positions.col(i);
      const double now = shapes_[s].distance(x);
      Eigen::Vector3d place = x, ahead = x + w * velocities.col(i);
      double nearest = now;
      const auto consider = [&](const Eigen::Vector3d& other) {
        const double distance = shapes_[s].distance(other);
        if (!(distance < nearest)) return;
        nearest = distance;
        place = other;
      };
      consider(ahead);
      if (missed_) consider(ends_.col(i));
      if (!(nearest < options_.thickness)) continue;
      known_[i * shapes_.size() + s] = 1;
      const Surface surface = shapes_[s].at(place);
      const double depth = options_.thickness - surface.distance;
      // k (depth - n . (x + w u - place)) with the new velocities u.
      const Eigen::Vector3d& n = surface.normal;
      forces.col(i) += k * (depth + n.dot(place - x)) * n;
      SymmetricBlock& block = matrix.diagonal()[i];
      block += SymmetricBlock::axial(n, w * w * k, 0.0);
      if (!surface.curvature.isZero(0.0)) ++projected;
      if (friction_ == 0.0) continue;
      // What presses now, or what is left of what lies ahead once the step has kept it out.
      const double mass = masses_[i];
      const double left = depth * mass / (mass + w * w * k);
      const double limit = friction_ * k * std::max(options_.thickness - now, left);
      // Damping brakes to the velocity of the shape, not to rest.
      const Eigen::Vector3d shape = across(n, shapes_[s].velocityAt(place));
      const Eigen::Vector3d sliding = across(n, velocities.col(i)) - shape;
      const double speed = sliding.norm();
      const double secant = limit * slip(speed).secant;
      SymmetricBlock braked = SymmetricBlock::axial(n, 0.0, w * secant);
      forces.col(i) += secant * shape;
      if (speed > options_.slip_velocity + w * limit / mass) {
        const Eigen::Vector3d along = sliding / speed;
        forces.col(i) -= secant * (sliding + along.dot(shape) * along);
        braked -= SymmetricBlock::axial(along, w * secant, 0.0);
      }
      block += braked;
    }
  }
  missed_ = false;
  return projected;
}

bool Contact::foresaw(const Vectors& ends) const {
  for (std::uint32_t i = 0; i < masses_.size() && !missed_; ++i) {
    for (std::uint32_t s = 0; s < shapes_.size() && !missed_; ++s) {
      missed_ = !known_[i * shapes_.size() + s] &&
                options_.thickness - shapes_[s].distance(ends.col(i)) > length();
    }
  }
  if (missed_) ends_ = ends;
  return !missed_;
}

void Contact::addBounds(Eigen::VectorXd& stiffness, Eigen::VectorXd& damping) const {
  const double k = options_.stiffness * static_cast<double>(shapes_.size());
  stiffness.array() += k;
  // Pressed in as deep as contact can be meant to be.
  damping.array() += 2.0 * friction_ * k * length() / options_.slip_velocity;
}

double Contact::length() const {
  // Particles that touch without any thickness are still nowhere near a meter apart.
  return options_.thickness > 0.0 ? options_.thickness : 0.01;
}

Eigen::Vector3d Contact::force(const Shape& shape, const Surface& surface, double depth,
                               const Eigen::Vector3d& x, const Eigen::Vector3d& v) const {
  const Eigen::Vector3d sliding = across(surface.normal, v - shape.velocityAt(x));
  const double rub = friction_ * slip(sliding.norm()).secant;
  return options_.stiffness * depth * (surface.normal - rub * sliding);
}

double Contact::power(const Vectors& positions, const Vectors& velocities) const {
  double power = 0.0;
  if (std::none_of(shapes_.begin(), shapes_.end(), [](const Shape& s) { return s.moves(); })) {
    return power;
  }
  forEachContact(
      positions, [&](std::uint32_t i, std::uint32_t s, const Surface& surface, double depth) {
        const Eigen::Vector3d x = positions.col(i), v = velocities.col(i);
        const double fed = force(shapes_[s], surface, depth, x, v).dot(shapes_[s].velocityAt(x));
        power += std::max(0.0, fed);
      });
  return power;
}

std::vector<Touch> Contact::touches(const Vectors& positions, const Vectors& velocities) const {
  std::vector<Touch> touches;
  forEachContact(
      positions, [&](std::uint32_t i, std::uint32_t s, const Surface& surface, double depth) {
        touches.push_back(
            {i, s, force(shapes_[s], surface, depth, positions.col(i), velocities.col(i))});
      });
  return touches;
}

}  // namespace mass_spring
