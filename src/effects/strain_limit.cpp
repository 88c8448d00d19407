#include "effects/strain_limit.h"

#include <cmath>

#include "solvers/step_matrix.h"

namespace mass_spring {
namespace {

/// What a spring of length l along d pulls its ends together with, S of the class comment.
SymmetricBlock stiffnessBeyond(const Eigen::Vector3d& d, double length, double longest,
                               double stiffness) {
  return SymmetricBlock::axial(d / length, stiffness, stiffness * (1.0 - longest / length));
}

}  // namespace

StrainLimit::StrainLimit(const StrainLimitOptions& options, const std::vector<Spring>& springs)
    : Effect(Traits{{"strain_limit"}}) {
  for (const Spring& s : springs) {
    if (s.kind == SpringKind::kBending || s.rest_length == 0.0 || s.stiffness == 0.0) continue;
    springs_.push_back({s.i, s.j, (1.0 + options.max_strain) * s.rest_length,
                        options.stiffness_ratio * s.stiffness, 0});
  }
}

template <typename Visit>
void StrainLimit::forEachBeyond(const Vectors& positions, Visit visit) const {
  for (const Limited& s : springs_) {
    const Eigen::Vector3d d = positions.col(s.j) - positions.col(s.i);
    const double square = d.squaredNorm();
    if (square > s.longest * s.longest) visit(s, d, std::sqrt(square));
  }
}

void StrainLimit::add(const Point& point, Scratch* /*scratch*/, const Sums& sums) const {
  forEachBeyond(point.positions, [&](const Limited& s, const Eigen::Vector3d& d, double length) {
    if (sums.energy) {
      const double excess = length - s.longest;
      sums.energy->elastic += 0.5 * s.stiffness * excess * excess;
    }
    if (sums.forces) {
      const Eigen::Vector3d f = s.stiffness * (1.0 - s.longest / length) * d;
      sums.forces->col(s.i) += f;
      sums.forces->col(s.j) -= f;
    }
  });
}

void StrainLimit::addForceDerivative(const Point& point, Scratch* /*scratch*/, const Vectors& dx,
                                     const Vectors& /*dv*/, Vectors& df) const {
  forEachBeyond(point.positions, [&](const Limited& s, const Eigen::Vector3d& d, double length) {
    const Eigen::Vector3d apart = dx.col(s.j) - dx.col(s.i);
    Eigen::Vector3d f = Eigen::Vector3d::Zero();
    stiffnessBeyond(d, length, s.longest, s.stiffness).multiplyAdd(apart.data(), f.data());
    df.col(s.i) += f;
    df.col(s.j) -= f;
  });
}

void StrainLimit::addPattern(PatternBuilder& pattern) const {
  for (const Limited& s : springs_) pattern.couple(s.i, s.j);
}

void StrainLimit::findSlots(const BlockPattern& pattern) {
  for (Limited& s : springs_) s.slot = pattern.slot(s.i, s.j);
}

std::uint32_t StrainLimit::addDerivatives(const Point& point, Scratch* /*scratch*/,
                                          const MatrixWeights& weights, Projection /*projection*/,
                                          StepMatrix& matrix) const {
  if (weights.stiffness == 0.0) return 0;
  forEachBeyond(point.positions, [&](const Limited& s, const Eigen::Vector3d& d, double length) {
    const double weighted = weights.stiffness * s.stiffness;
    matrix.addElement(s.i, s.j, s.slot, stiffnessBeyond(d, length, s.longest, weighted));
  });
  return 0;
}

std::uint32_t StrainLimit::linearize(const Point& point, Scratch* /*scratch*/, double w,
                                     StepMatrix& matrix, Vectors& forces) const {
  const Vectors &positions = point.positions, &velocities = point.velocities;
  for (const Limited& s : springs_) {
    const Eigen::Vector3d d = positions.col(s.j) - positions.col(s.i);
    const Eigen::Vector3d ahead = w * (velocities.col(s.j) - velocities.col(s.i));
    const bool expected = (d + ahead).squaredNorm() > d.squaredNorm();
    const Eigen::Vector3d about = expected ? Eigen::Vector3d(d + ahead) : d;
    const double length = about.norm();
    if (!(length > s.longest)) continue;
    // f_i(d + w u) = f_i(about) + S (d - about) + w S u with the new relative velocity u.
    Eigen::Vector3d f = s.stiffness * (1.0 - s.longest / length) * about;
    const Eigen::Vector3d back = d - about;
    stiffnessBeyond(about, length, s.longest, s.stiffness).multiplyAdd(back.data(), f.data());
    forces.col(s.i) += f;
    forces.col(s.j) -= f;
    const double weighted = w * w * s.stiffness;
    matrix.addElement(s.i, s.j, s.slot, stiffnessBeyond(about, length, s.longest, weighted));
  }
  return 0;
}

void StrainLimit::addBounds(Eigen::VectorXd& stiffness, Eigen::VectorXd& /*damping*/) const {
  for (const Limited& s : springs_) {
    stiffness[s.i] += 2.0 * s.stiffness;
    stiffness[s.j] += 2.0 * s.stiffness;
  }
}

}  // namespace mass_spring
