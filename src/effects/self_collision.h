#pragma once

#include <vector>

#include "effects/broad_phase.h"
#include "effects/effect.h"

namespace mass_spring {

/// Elements that push each other apart from the thickness t on: E = k/2 (t - g)^2 with the gap g
/// between them, the distance of their nearest points. An element that has passed through the other
/// one since the sub-step began (on a straight way) has the gap minus its distance, so that it is
/// pushed back through and not out on the far side. With the gradient G of g,
/// K = k G G^T - k (t - g) dG/dx, of which a matrix gets the first part, as a tie; the second is
/// negative where it matters, so that without it matrices are definite and steps descend.
/// Between sub-steps, what follows from positions does not depend on earlier ones.
class SelfCollision : public Effect, public SweptEffect {
 public:
  /// @param model  has its particles, springs, triangles and rate already
  SelfCollision(const SelfCollisionOptions& options, const Model& model);

  std::unique_ptr<Scratch> makeScratch(ThreadPool& threads) const override;
  void beginSubstep(Scratch& scratch, const Vectors& positions, const Vectors& velocities,
                    double h) const override;
  bool endSubstep(Scratch& scratch, const Vectors& positions) const override;
  void add(const Point& point, Scratch* scratch, const Sums& sums) const override;
  void addForceDerivative(const Point& point, Scratch* scratch, const Vectors& dx,
                          const Vectors& dv, Vectors& df) const override;
  std::uint32_t addDerivatives(const Point& point, Scratch* scratch, const MatrixWeights& weights,
                               Projection projection, StepMatrix& matrix) const override;
  /// About the positions that are to be expected, or about the first touch on the way there.
  std::uint32_t linearize(const Point& point, Scratch* scratch, double w, StepMatrix& matrix,
                          Vectors& forces) const override;
  void addBounds(Eigen::VectorXd& stiffness, Eigen::VectorXd& damping) const override;

 private:
  struct Push;
  class Room;
  double stiffness(const ElementPair& pair) const {
    return stiffness_[static_cast<std::size_t>(pair.elements)];
  }
  static Room& roomOf(Scratch* scratch);

  CollisionElements elements_;
  double thickness_;
  std::array<double, 2> stiffness_;  // N/m, by Elements
};

}  // namespace mass_spring
