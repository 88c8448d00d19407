#pragma once

#include <vector>

#include "effects/effect.h"
#include "mass_spring_sim/model.h"

namespace mass_spring {

/// Damping along springs: f_i = k_d (v_ij . n) n (course notes eq. 2). The derivative that eq. 18
/// leaves to the reader, with D = -df/dv: the spring adds [B -B; -B B] with B = k_d n n^T,
/// positive semidefinite. Its dependence on the positions stays out of the matrix (the notes).
class SpringDamping : public Effect {
 public:
  explicit SpringDamping(const std::vector<Spring>& springs);
  std::string name() const override { return "spring_damping"; }
  double dissipation(const Vectors& positions, const Vectors& velocities) const override;
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
    double damping;
    std::size_t slot;
  };
  std::vector<Element> elements_;
};

}  // namespace mass_spring
