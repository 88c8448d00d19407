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

// With d = x_j - x_i = l n and w = v_j - v_i, f_i = k_d (w . n) n changes by
//   df_i = k_d [(dw . n + w . dn) n + (w . n) dn],  dn = (I - n n^T) dd / l.
// Where the ends coincide n is a constant that stands in for a direction, and dn = 0.
void SpringDamping::addForceDerivative(const Vectors& x, const Vectors& v, const Vectors& dx,
                                       const Vectors& dv, Vectors& df) const {
  for (const Element& e : elements_) {
    const SpringDirection direction(x.col(e.j) - x.col(e.i));
    const Eigen::Vector3d& n = direction.n;
    const Eigen::Vector3d dd = dx.col(e.j) - dx.col(e.i);
    Eigen::Vector3d dn = Eigen::Vector3d::Zero();
    if (direction.length > 0.0) dn = (dd - n.dot(dd) * n) / direction.length;
    const Eigen::Vector3d w = v.col(e.j) - v.col(e.i);
    const Eigen::Vector3d dw = dv.col(e.j) - dv.col(e.i);
    const Eigen::Vector3d f = e.damping * ((dw.dot(n) + w.dot(dn)) * n + w.dot(n) * dn);
    df.col(e.i) += f;
    df.col(e.j) -= f;
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
