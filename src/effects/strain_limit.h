#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "effects/effect.h"

namespace mass_spring {

/// Springs that stiffen once they are stretched beyond a limit (Provot, "Deformation constraints in
/// a mass-spring model", 1995, asks for a limit; here it is a force, which schemes treat at their
/// order): with the length l, its unit vector n and the longest length M = (1 + max_strain) L,
///   E = r k (l - M)^2 / 2,   f_i = r k (l - M) n,   S = r k (n n^T + (1 - M / l) (I - n n^T))
/// where l > M, on top of the spring's own k (l - L). As l > M, S is positive definite as it is.
/// Bending springs are not limited: structural ones limit those that run along them, and the
/// others stretch where a fold opens. Its blocks are among those of the springs.
class StrainLimit : public Effect {
 public:
  StrainLimit(const StrainLimitOptions& options, const std::vector<Spring>& springs);

  void add(const Point& point, Scratch* scratch, const Sums& sums) const override;
  void addForceDerivative(const Point& point, Scratch* scratch, const Vectors& dx,
                          const Vectors& dv, Vectors& df) const override;
  void addPattern(PatternBuilder& pattern) const override;
  void findSlots(const BlockPattern& pattern) override;
  std::uint32_t addDerivatives(const Point& point, Scratch* scratch, const MatrixWeights& weights,
                               Projection projection, StepMatrix& matrix) const override;
  /// About the longer one of a spring as it is and as it is to be expected: what a step leads
  /// beyond the limit is held by that step already.
  std::uint32_t linearize(const Point& point, Scratch* scratch, double w, StepMatrix& matrix,
                          Vectors& forces) const override;
  /// [S -S; -S S] <= 2 r k at either end.
  void addBounds(Eigen::VectorXd& stiffness, Eigen::VectorXd& damping) const override;

 private:
  struct Limited {
    std::uint32_t i, j;
    double longest;    // m, M
    double stiffness;  // N/m, r k
    std::size_t slot;  // of its block
  };
  /// visit(spring, d = x_j - x_i, length) of all that are beyond their limit.
  template <typename Visit>
  void forEachBeyond(const Vectors& positions, Visit visit) const;

  std::vector<Limited> springs_;
};

}  // namespace mass_spring
