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

/// The shapes where they are at the point of the last evaluation, and what the last linearized step
/// knew of.
struct Contact::Room : Scratch {
  std::vector<PlacedShape> shapes;
  std::vector<char> known;  // the contacts, particle by particle
  Vectors ends;             // where that step ended, if it was in a shape it did not know of
  bool missed = false;      // was it?
};

Contact::Contact(const ContactOptions& options, std::vector<Shape> shapes,
                 const Eigen::VectorXd& masses)
    : Effect(Traits{{"contact"}}),
      options_(options),
      friction_(options.friction.value_or(0.0)),
      shapes_(std::move(shapes)),
      masses_(masses) {
  if (options.friction) traits_.names.push_back("friction");
  traits_.damping_depends_on_position = friction_ > 0.0;
  // Particles that touch without any thickness are still nowhere near a meter apart.
  traits_.length = options.thickness > 0.0 ? options.thickness : 0.01;
}

std::unique_ptr<Scratch> Contact::makeScratch(ThreadPool& /*threads*/) const {
  auto room = std::make_unique<Room>();
  room->shapes.reserve(shapes_.size());
  room->known.resize(static_cast<std::size_t>(masses_.size()) * shapes_.size());
  room->ends.resize(3, masses_.size());
  return room;
}

const std::vector<PlacedShape>& Contact::place(const Point& point, Scratch* scratch) const {
  std::vector<PlacedShape>& placed = static_cast<Room*>(scratch)->shapes;
  placed.clear();
  for (std::size_t s = 0; s < shapes_.size(); ++s) {
    placed.emplace_back(shapes_[s], point.effects.shapes[s], point.time);
  }
  return placed;
}

template <typename Visit>
void Contact::forEachContact(const std::vector<PlacedShape>& shapes, const Vectors& positions,
                             Visit visit) const {
  for (std::uint32_t i = 0; i < masses_.size(); ++i) {
    const Eigen::Vector3d x = positions.col(i);
    for (std::uint32_t s = 0; s < shapes.size(); ++s) {
      if (!(shapes[s].distance(x) < options_.thickness)) continue;
      const Surface surface = shapes[s].at(x);
      visit(i, s, surface, options_.thickness - surface.distance);
    }
  }
}

bool Contact::dependsOnTime(const Point& point) const {
  return std::any_of(point.effects.shapes.begin(), point.effects.shapes.end(),
                     [&](const RigidMotion& motion) { return motion.lasts(point.time); });
}

Contact::Slip Contact::slip(double speed) const {
  const double e = options_.slip_velocity;
  if (speed < e) return {(2.0 - speed / e) / e, -speed / (e * e)};
  return {1.0 / speed, -1.0 / speed};
}

void Contact::add(const Point& point, Scratch* scratch, const Sums& sums) const {
  const std::vector<PlacedShape>& shapes = place(point, scratch);
  const double k = options_.stiffness, e = options_.slip_velocity;
  const auto press = [&](std::uint32_t i, const Surface& surface, double depth) {
    if (sums.energy) sums.energy->elastic += 0.5 * k * depth * depth;
    if (sums.forces) sums.forces->col(i) += k * depth * surface.normal;
  };
  const auto rub = [&](std::uint32_t i, std::uint32_t s, const Surface& surface, double depth,
                       const Eigen::Vector3d& x) {
    const double limit = friction_ * k * depth;
    const Eigen::Vector3d sliding =
        across(surface.normal, point.velocities.col(i) - shapes[s].velocityAt(x));
    const double speed = sliding.norm(), y = speed / e;
    sums.forces->col(i) -= limit * slip(speed).secant * sliding;
    if (sums.dissipation) {
      *sums.dissipation += limit * e * (y < 1.0 ? y * y * (1.0 - y / 3.0) : y - 1.0 / 3.0);
    }
  };
  const bool rubs = friction_ > 0.0 && sums.forces;
  const Vectors* const held = sums.damping_positions;
  forEachContact(shapes, point.positions,
                 [&](std::uint32_t i, std::uint32_t s, const Surface& surface, double depth) {
                   press(i, surface, depth);
                   if (rubs && !held) rub(i, s, surface, depth, point.positions.col(i));
                 });
  if (!rubs || !held) return;
  forEachContact(shapes, *held,
                 [&](std::uint32_t i, std::uint32_t s, const Surface& surface, double depth) {
                   rub(i, s, surface, depth, held->col(i));
                 });
}

// With N = k p, u = v - (n . v) n, v beyond the velocity of the shape: dN = -k n . dx, dn = H dx,
// du = dv across n - (dn . v) n - (n . v) dn, and what dv has along n stays out.
void Contact::addForceDerivative(const Point& point, Scratch* scratch, const Vectors& dx,
                                 const Vectors& dv, Vectors& df) const {
  const std::vector<PlacedShape>& shapes = place(point, scratch);
  const Vectors &x = point.positions, &v = point.velocities;
  const auto add = [&](std::uint32_t i, std::uint32_t s, const Surface& surface, double depth) {
    const Eigen::Vector3d& n = surface.normal;
    const double pressure = options_.stiffness * depth;
    const double more = -options_.stiffness * n.dot(dx.col(i));
    const Eigen::Vector3d dn = surface.curvature * dx.col(i);
    df.col(i) += more * n + pressure * dn;
    if (friction_ == 0.0) return;
    const Eigen::Vector3d slip_v = v.col(i) - shapes[s].velocityAt(x.col(i));
    const Eigen::Vector3d slip_dv = dv.col(i) - shapes[s].spin().cross(dx.col(i));
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
  };
  forEachContact(shapes, x, add);
}

std::uint32_t Contact::addDerivatives(const Point& point, Scratch* scratch,
                                      const MatrixWeights& weights, Projection projection,
                                      StepMatrix& matrix) const {
  const std::vector<PlacedShape>& shapes = place(point, scratch);
  const Vectors &positions = point.positions, &velocities = point.velocities;
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
          across(n, velocities.col(i) - shapes[s].velocityAt(positions.col(i)));
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
  forEachContact(shapes, positions, add);
  return projected;
}

std::uint32_t Contact::linearize(const Point& point, Scratch* scratch, double w, StepMatrix& matrix,
                                 Vectors& forces) const {
  Room& room = *static_cast<Room*>(scratch);
  const std::vector<PlacedShape>& shapes = place(point, scratch);
  const Vectors &positions = point.positions, &velocities = point.velocities;
  const double k = options_.stiffness;
  std::uint32_t projected = 0;
  std::fill(room.known.begin(), room.known.end(), 0);
  for (std::uint32_t i = 0; i < masses_.size(); ++i) {
    for (std::uint32_t s = 0; s < shapes.size(); ++s) {
      // About the deepest one of where a particle is, where it is to be expected, and where it has
      // just been seen to go: what lies ahead is kept out by this step already, and what is pushed
      // out does not fall back in.
      const Eigen::Vector3d x = positions.col(i);
      const double now = shapes[s].distance(x);
      Eigen::Vector3d place = x, ahead = x + w * velocities.col(i);
      double nearest = now;
      const auto consider = [&](const Eigen::Vector3d& other) {
        const double distance = shapes[s].distance(other);
        if (!(distance < nearest)) return;
        nearest = distance;
        place = other;
      };
      consider(ahead);
      if (room.missed) consider(room.ends.col(i));
      if (!(nearest < options_.thickness)) continue;
      room.known[i * shapes.size() + s] = 1;
      const Surface surface = shapes[s].at(place);
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
      const Eigen::Vector3d shape = across(n, shapes[s].velocityAt(place));
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
  room.missed = false;
  return projected;
}

bool Contact::linearizationCovered(const Point& end, Scratch* scratch) const {
  Room& room = *static_cast<Room*>(scratch);
  const std::vector<PlacedShape>& shapes = place(end, scratch);
  const auto missed = [&](std::uint32_t i, std::size_t s) {
    return !room.known[i * shapes.size() + s] &&
           options_.thickness - shapes[s].distance(end.positions.col(i)) > traits_.length;
  };
  for (std::uint32_t i = 0; i < masses_.size() && !room.missed; ++i) {
    for (std::size_t s = 0; s < shapes.size() && !room.missed; ++s) room.missed = missed(i, s);
  }
  if (room.missed) room.ends = end.positions;
  return !room.missed;
}

void Contact::addBounds(Eigen::VectorXd& stiffness, Eigen::VectorXd& damping) const {
  const double k = options_.stiffness * static_cast<double>(shapes_.size());
  stiffness.array() += k;
  // Pressed in as deep as contact can be meant to be.
  damping.array() += 2.0 * friction_ * k * traits_.length / options_.slip_velocity;
}

Eigen::Vector3d Contact::force(const PlacedShape& shape, const Surface& surface, double depth,
                               const Eigen::Vector3d& x, const Eigen::Vector3d& v) const {
  const Eigen::Vector3d sliding = across(surface.normal, v - shape.velocityAt(x));
  const double rub = friction_ * slip(sliding.norm()).secant;
  return options_.stiffness * depth * (surface.normal - rub * sliding);
}

double Contact::power(const Point& point, Scratch* scratch) const {
  double power = 0.0;
  if (!dependsOnTime(point)) return power;
  const std::vector<PlacedShape>& shapes = place(point, scratch);
  const auto add = [&](std::uint32_t i, std::uint32_t s, const Surface& surface, double depth) {
    const Eigen::Vector3d x = point.positions.col(i), v = point.velocities.col(i);
    power += std::max(0.0, force(shapes[s], surface, depth, x, v).dot(shapes[s].velocityAt(x)));
  };
  forEachContact(shapes, point.positions, add);
  return power;
}

std::vector<Touch> Contact::touches(const Point& point, Scratch* scratch) const {
  const std::vector<PlacedShape>& shapes = place(point, scratch);
  std::vector<Touch> touches;
  const auto add = [&](std::uint32_t i, std::uint32_t s, const Surface& surface, double depth) {
    touches.push_back(
        {i, s, force(shapes[s], surface, depth, point.positions.col(i), point.velocities.col(i))});
  };
  forEachContact(shapes, point.positions, add);
  return touches;
}

}  // namespace mass_spring
