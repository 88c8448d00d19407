#pragma once

#include <vector>

#include "effects/effect.h"
#include "mass_spring_sim/model.h"
#include "solvers/symmetric_block.h"

namespace mass_spring {

/// Stiffness block S = d^2E/dd^2 of one spring (course notes eq. 17, with K = -df/dx); the spring
/// adds [S -S; -S S] to K.
///   S = k n n^T + k r (I - n n^T),  r = 1 - L/l,  d = x_j - x_i = l n
/// Its eigenvalues are k along the spring and k r across it, negative in compression. With r
/// replaced by max(r, 0) it is the nearest positive semidefinite matrix.
SymmetricBlock springStiffness(const Eigen::Vector3d& d, double stiffness, double rest_length,
                               bool project);

/// Elastic springs: E = k/2 (l - L)^2 (eq. 5), f_i = k (l - L) n (eq. 1).
class Springs : public Effect {
 public:
  explicit Springs(const std::vector<Spring>& springs);
  std::string name() const override { return "springs"; }
  void addEnergy(const Vectors& positions, Energy& energy) const override;
  void addForces(const Vectors& positions, const Vectors& velocities,
                 Vectors& forces) const override;
  void addForceDerivative(const Vectors& x, const Vectors& v, const Vectors& dx, const Vectors& dv,
                          Vectors& df) const override;
  void addPattern(PatternBuilder& pattern) const override;
  void findSlots(const BlockPattern& pattern) override;
  std::uint32_t addDerivatives(const Vectors& positions, const MatrixWeights& weights,
                               Projection projection, StepMatrix& matrix) const override;

 private:
  struct Element {
    std::uint32_t i, j;
    double stiffness, rest_length;
    std::size_t slot;
  };
  std::vector<Element> elements_;
};

}  // namespace mass_spring
