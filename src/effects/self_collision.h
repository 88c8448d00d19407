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
/// What follows from positions does not depend on earlier ones between sub-steps.
class SelfCollision : public Effect {
 public:
  /// @param model  has its particles, springs, triangles and threads already
  /// @param rate   Hz, of steps
  SelfCollision(const SelfCollisionOptions& options, const Model& model, double rate);

  std::vector<std::string> names() const override { return {"self_collision"}; }

  void beginSubstep(const Vectors& positions, const Vectors& velocities, double h) override;
  bool endSubstep(const Vectors& positions) override;
  bool ties() const override { return true; }

  void addEnergy(const Vectors& positions, Energy& energy) const override;
  void addForces(const Vectors& positions, const Vectors& velocities,
                 Vectors& forces) const override;
  void addForces(const Vectors& positions, const Vectors& velocities, Vectors& forces,
                 Energy& energy, double& dissipation) const override;
  void addForceDerivative(const Vectors& x, const Vectors& v, const Vectors& dx, const Vectors& dv,
                          Vectors& df) const override;
  std::uint32_t addDerivatives(const Vectors& positions, const Vectors& velocities,
                               const MatrixWeights& weights, Projection projection,
                               StepMatrix& matrix) const override;
  /// About the positions that are to be expected, or about the first touch on the way there.
  std::uint32_t linearize(const Vectors& positions, const Vectors& velocities, double w,
                          StepMatrix& matrix, Vectors& forces) const override;
  void addBounds(Eigen::VectorXd& stiffness, Eigen::VectorXd& damping) const override;
  double length() const override { return thickness_; }

 private:
  /// What elements feel of each other.
  struct Push {
    const ElementPair* pair;
    Proximity near;
    bool passed;  ///< through each other
    /// Along the normal, with the weights.
    double side() const { return passed ? -1.0 : 1.0; }
  };
  double depth(const Push& push) const { return thickness_ - push.side() * push.near.distance; }
  /// Of all pairs that push each other: in pushes_.
  void findPushes(const Vectors& positions) const;
  /// Where elements have passed through others, what lies beside these sees them on the wrong side,
  /// without having been passed itself: it has no say.
  void dropBesidePassed(const Vectors& from, const Vectors& to) const;
  /// Pairs for these positions and the way there from where the sub-step began. @return m, those
  /// that are to be further apart push nothing at these positions, and have not passed on this way
  double cover(const Vectors& positions) const;
  /// Finds the pairs for the way there.
  void refresh(const Vectors& positions) const;
  /// m, at most that of the pair where the sub-step that is under way began.
  double startDistance(std::size_t pair) const;
  /// m, the distance where it is below the thickness, else no more than that.
  double distanceWithin(const ElementPair& pair, const Corners& x) const;
  /// vectors += the push of a force [N], or what is like one, on the first element
  static void spread(const Push& push, const Eigen::Vector3d& force, Vectors& vectors);

  double stiffness(const ElementPair& pair) const {
    return stiffness_[static_cast<std::size_t>(pair.elements)];
  }

  double thickness_;
  std::array<double, 2> stiffness_;  // N/m, by Elements
  mutable BroadPhase broad_;
  mutable std::vector<Push> pushes_;
  mutable std::vector<char> beside_;             // per particle, whether something has passed it
  mutable std::vector<double> start_distances_;  // m, of the pairs, while a sub-step is under way
  mutable double start_strayed_ = 0.0;           // m, as far as particles had when it began
  bool under_way_ = false;
  Vectors start_;
  mutable Vectors expected_;
};

}  // namespace mass_spring
