#include "effects/spring_damping.h"

#include "effects/spring_direction.h"
#include "solvers/step_matrix.h"

namespace mass_spring {

SpringDamping::SpringDamping(const std::vector<Spring>& springs) {
  for (const Spring& s : springs) {
    if (s.damping > 0.0) elements_.push_back({s.i, s.j, s.damping, 0});
  }
}

double SpringDamping::dissipation(const Vectors& positions, const Vectors& velocities) const {
  double sum = 0.0;
  for (const Element& e : elements_) {
    const SpringDirection direction(positions.col(e.j) - positions.col(e.i));
    const double rate = (velocities.col(e.j) - velocities.col(e.i)).dot(direction.n);
    sum += 0.5 * e.damping * rate * rate;
  }
  return sum;
}

void SpringDamping::addForces(const Vectors& positions, const Vectors& velocities,
                              Vectors& forces) const {
  for (const Element& e : elements_) {
    const SpringDirection direction(positions.col(e.j) - positions.col(e.i));
    const double rate = (velocities.col(e.j) - velocities.col(e.i)).dot(direction.n);
    const Eigen::Vector3d f = e.damping * rate * direction.n;
    forces.col(e.i) += f;
    forces.col(e.j) -= f;
  }
}

void SpringDamping::addPattern(PatternBuilder& pattern) const {
  for (const Element& e : elements_) pattern.couple(e.i, e.j);
}

void SpringDamping::findSlots(const BlockPattern& pattern) {
  for (Element& e : elements_) e.slot = pattern.slot(e.i, e.j);
}

std::uint32_t SpringDamping::addDerivatives(const Vectors& positions, const MatrixWeights& weights,
                                            Projection /*projection*/, StepMatrix& matrix) const {
  for (const Element& e : elements_) {
    const SpringDirection direction(positions.col(e.j) - positions.col(e.i));
    matrix.addElement(e.i, e.j, e.slot,
                      SymmetricBlock::axial(direction.n, weights.damping * e.damping, 0.0));
  }
  return 0;
}

}  // namespace mass_spring
