#include "effects/wind.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "solvers/step_matrix.h"

namespace mass_spring {
namespace {

constexpr double kTurn = 6.28318530717958647692;  // rad

Eigen::Vector3d areaVector(const Vectors& x, const std::array<std::uint32_t, 3>& face) {
  const Eigen::Vector3d to_b = x.col(face[1]) - x.col(face[0]);
  const Eigen::Vector3d to_c = x.col(face[2]) - x.col(face[0]);
  return 0.5 * to_b.cross(to_c);
}

/// How it changes where the corners move by dx.
Eigen::Vector3d areaChange(const Vectors& x, const Vectors& dx,
                           const std::array<std::uint32_t, 3>& face) {
  const Eigen::Vector3d to_b = x.col(face[1]) - x.col(face[0]);
  const Eigen::Vector3d to_c = x.col(face[2]) - x.col(face[0]);
  const Eigen::Vector3d db = dx.col(face[1]) - dx.col(face[0]);
  const Eigen::Vector3d dc = dx.col(face[2]) - dx.col(face[0]);
  return 0.5 * (db.cross(to_c) + to_b.cross(dc));
}

Eigen::Vector3d meanOf(const Vectors& a, const std::array<std::uint32_t, 3>& face) {
  return (a.col(face[0]) + a.col(face[1]) + a.col(face[2])) / 3.0;
}

void spread(const Eigen::Vector3d& force, const std::array<std::uint32_t, 3>& face,
            Vectors& forces) {
  for (const std::uint32_t corner : face) forces.col(corner) += force / 3.0;
}

}  // namespace

Wind::Wind(const WindOptions& options, const Model& model)
    : Effect(Traits{{"wind"}, false, true}),
      options_(options),
      drag_(0.5 * options.density * options.drag),
      lift_(0.5 * options.density * options.lift),
      faces_(model.triangles),
      damping_bounds_(Eigen::VectorXd::Zero(model.masses.size())) {
  const double strongest =
      options.velocity.norm() * (1.0 + (options.gust ? options.gust->amplitude : 0.0));
  double fastest = strongest;
  for (Eigen::Index i = 0; i < model.start.velocities.cols(); ++i) {
    fastest = std::max(fastest, model.start.velocities.col(i).norm());
  }
  // The norm of dF/du is at most A |u| (2 drag + 1.033 lift): drag's where u is along n, lift's,
  // which is sqrt(16 / 15), in between. A third for each corner.
  const double per_area = (strongest + fastest) * (2.0 * drag_ + 1.033 * lift_) / 3.0;
  for (const Corners& face : faces_) {
    const double bound = per_area * areaVector(model.start.positions, face).norm();
    for (const std::uint32_t corner : face) damping_bounds_[corner] += bound;
  }
}

Eigen::Vector3d Wind::velocityAt(double time) const {
  if (!options_.gust) return options_.velocity;
  const double phase = kTurn * time / options_.gust->period;
  return options_.velocity * (1.0 + options_.gust->amplitude * std::sin(phase));
}

Eigen::Vector3d Wind::force(const Eigen::Vector3d& S, const Eigen::Vector3d& u) const {
  const double q = S.dot(u), area = S.norm(), speed = u.norm();
  if (area == 0.0 || speed == 0.0) return Eigen::Vector3d::Zero();
  return drag_ * std::abs(q) * u + lift_ * q / area * (speed * S - q / speed * u);
}

void Wind::add(const Point& point, Scratch* /*scratch*/, const Sums& sums) const {
  if (sums.forces == nullptr) return;
  // All of the force is damping.
  const Vectors& positions = sums.damping_positions ? *sums.damping_positions : point.positions;
  const Eigen::Vector3d wind = velocityAt(point.time);
  for (const Corners& face : faces_) {
    const Eigen::Vector3d S = areaVector(positions, face), v = meanOf(point.velocities, face);
    const Eigen::Vector3d whole = force(S, wind - v);
    if (sums.dissipation) {
      const Eigen::Vector3d sum = force(S, wind) + 4.0 * force(S, wind - 0.5 * v) + whole;
      *sums.dissipation -= sum.dot(v) / 6.0;
    }
    spread(whole, face, *sums.forces);
  }
}

double Wind::power(const Point& point, Scratch* /*scratch*/) const {
  const Eigen::Vector3d wind = velocityAt(point.time);
  double power = 0.0;
  for (const Corners& face : faces_) {
    const Eigen::Vector3d third =
        force(areaVector(point.positions, face), wind - meanOf(point.velocities, face)) / 3.0;
    for (const std::uint32_t corner : face) {
      power += std::max(0.0, third.dot(point.velocities.col(corner)));
    }
  }
  return power;
}

void Wind::addBounds(Eigen::VectorXd& /*stiffness*/, Eigen::VectorXd& damping) const {
  damping += damping_bounds_;
}

// With A = |S| and s = |u|, lift is c / A (q s S - q^2 u / s).
void Wind::addForceDerivative(const Point& point, Scratch* /*scratch*/, const Vectors& dx,
                              const Vectors& dv, Vectors& df) const {
  const Vectors& x = point.positions;
  const Eigen::Vector3d wind = velocityAt(point.time);
  for (const Corners& face : faces_) {
    const Eigen::Vector3d S = areaVector(x, face), u = wind - meanOf(point.velocities, face);
    const double q = S.dot(u), area = S.norm(), speed = u.norm();
    if (area == 0.0 || speed == 0.0) continue;
    const Eigen::Vector3d dS = areaChange(x, dx, face), du = -meanOf(dv, face), along = u / speed;
    const double dq = dS.dot(u) + S.dot(du), ds = along.dot(du), share = q / speed;
    const Eigen::Vector3d lift = q * speed * S - q * q * along;
    const Eigen::Vector3d change = (dq * speed + q * ds) * S + q * speed * dS -
                                   2.0 * q * dq * along - q * share * (du - ds * along);
    const Eigen::Vector3d more = lift_ / area * (change - S.dot(dS) / (area * area) * lift);
    spread(drag_ * (std::copysign(1.0, q) * dq * u + std::abs(q) * du) + more, face, df);
  }
}

std::uint32_t Wind::addDerivatives(const Point& point, Scratch* /*scratch*/,
                                   const MatrixWeights& weights, Projection /*projection*/,
                                   StepMatrix& matrix) const {
  if (weights.damping == 0.0) return 0;
  const Eigen::Vector3d wind = velocityAt(point.time);
  for (const Corners& face : faces_) {
    const Eigen::Vector3d S = areaVector(point.positions, face);
    const double area = S.norm();
    if (area == 0.0) continue;
    const double d = drag_ / 3.0 * std::abs(S.dot(wind - meanOf(point.velocities, face)));
    const SymmetricBlock block =
        SymmetricBlock::axial(S / area, 2.0 * d * weights.damping, d * weights.damping);
    for (const std::uint32_t corner : face) matrix.diagonal()[corner] += block;
  }
  return 0;
}

std::uint32_t Wind::linearize(const Point& point, Scratch* /*scratch*/, double w,
                              StepMatrix& matrix, Vectors& forces) const {
  const Eigen::Vector3d wind = velocityAt(point.time);
  for (const Corners& face : faces_) {
    const Eigen::Vector3d S = areaVector(point.positions, face);
    const Eigen::Vector3d u = wind - meanOf(point.velocities, face);
    const double area = S.norm();
    if (area == 0.0) continue;
    const Eigen::Vector3d n = S / area;
    const double d = drag_ / 3.0 * std::abs(S.dot(u));
    for (const std::uint32_t corner : face) {
      const Eigen::Vector3d v = point.velocities.col(corner);
      forces.col(corner) += d * (v + n.dot(v) * n);
      matrix.diagonal()[corner] += SymmetricBlock::axial(n, 2.0 * d * w, d * w);
    }
    spread(force(S, u), face, forces);
  }
  return 0;
}

}  // namespace mass_spring
