#include "effects/springs.h"

#include <algorithm>
#include <cmath>

#include "effects/spring_direction.h"
#include "solvers/step_matrix.h"

namespace mass_spring {
namespace {

/// r = 1 - L/l, the share of k that acts across the spring; -infinity where the ends coincide.
double transverseRatio(double length, double rest_length) {
  if (rest_length == 0.0) return 1.0;  // linear, also at length 0
  return 1.0 - rest_length / length;
}

}  // namespace

SymmetricBlock springStiffness(const Eigen::Vector3d& d, double stiffness, double rest_length,
                               bool project) {
  const SpringDirection direction(d);
  double r = transverseRatio(direction.length, rest_length);
  if (project) r = std::max(r, 0.0);
  return SymmetricBlock::axial(direction.n, stiffness, stiffness * r);
}

Springs::Springs(const std::vector<Spring>& springs) {
  elements_.reserve(springs.size());
  for (const Spring& s : springs) {
    if (s.stiffness > 0.0) elements_.push_back({s.i, s.j, s.stiffness, s.rest_length, 0});
  }
}

void Springs::addEnergy(const Vectors& positions, Energy& energy) const {
  double sum = 0.0;
  for (const Element& e : elements_) {
    const double stretch = (positions.col(e.j) - positions.col(e.i)).norm() - e.rest_length;
    sum += 0.5 * e.stiffness * stretch * stretch;
  }
  energy.elastic += sum;
}

void Springs::addForces(const Vectors& positions, const Vectors& /*velocities*/,
                        Vectors& forces) const {
  for (const Element& e : elements_) {
    const SpringDirection direction(positions.col(e.j) - positions.col(e.i));
    const Eigen::Vector3d f = e.stiffness * (direction.length - e.rest_length) * direction.n;
    forces.col(e.i) += f;
    forces.col(e.j) -= f;
  }
}

void Springs::addForceDerivative(const Vectors& x, const Vectors& /*v*/, const Vectors& dx,
                                 const Vectors& /*dv*/, Vectors& df) const {
  for (const Element& e : elements_) {
    const Eigen::Vector3d d = x.col(e.j) - x.col(e.i);
    // Where the ends coincide there is no exact derivative.
    const bool project = !std::isfinite(transverseRatio(d.norm(), e.rest_length));
    const Eigen::Vector3d change = dx.col(e.j) - dx.col(e.i);
    double f[3] = {0.0, 0.0, 0.0};
    springStiffness(d, e.stiffness, e.rest_length, project).multiplyAdd(change.data(), f);
    df.col(e.i) += Eigen::Map<const Eigen::Vector3d>(f);
    df.col(e.j) -= Eigen::Map<const Eigen::Vector3d>(f);
  }
}

void Springs::addPattern(PatternBuilder& pattern) const {
  for (const Element& e : elements_) pattern.couple(e.i, e.j);
}

void Springs::findSlots(const BlockPattern& pattern) {
  for (Element& e : elements_) e.slot = pattern.slot(e.i, e.j);
}

std::uint32_t Springs::addDerivatives(const Vectors& positions, const MatrixWeights& weights,
                                      Projection projection, StepMatrix& matrix) const {
  // A compressed spring takes at most 2 k |r| from the diagonal of each of its ends, as
  // [1 -1; -1 1] <= 2 I. Where the mass outweighs the sum over its springs, the matrix stays
  // definite without projection; a spring is projected if that fails at one of its ends.
  Eigen::VectorXd& taken = matrix.indefiniteness();
  taken.setZero();
  if (projection == Projection::kWhereNeeded) {
    for (const Element& e : elements_) {
      const double length = (positions.col(e.j) - positions.col(e.i)).norm();
      const double r = transverseRatio(length, e.rest_length);
      if (r < 0.0) {
        taken[e.i] -= 2.0 * weights.stiffness * e.stiffness * r;
        taken[e.j] -= 2.0 * weights.stiffness * e.stiffness * r;
      }
    }
  }
  std::uint32_t projected = 0;
  for (const Element& e : elements_) {
    const Eigen::Vector3d d = positions.col(e.j) - positions.col(e.i);
    const double r = transverseRatio(d.norm(), e.rest_length);
    const bool light = projection == Projection::kWhereNeeded &&
                       !(taken[e.i] < matrix.mass(e.i) && taken[e.j] < matrix.mass(e.j));
    // Where the ends coincide there is no exact derivative.
    const bool project = r < 0.0 && (light || !std::isfinite(r));
    matrix.addElement(e.i, e.j, e.slot,
                      springStiffness(d, weights.stiffness * e.stiffness, e.rest_length, project));
    if (project) ++projected;
  }
  return projected;
}

}  // namespace mass_spring
