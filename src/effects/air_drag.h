#pragma once

#include "effects/effect.h"

namespace mass_spring {

/// Still air that brakes each particle alike: f = -c v, Q = c |v|^2 / 2, D = c I.
class AirDrag : public Effect {
 public:
  /// @param coefficient  N s/m per particle, >= 0
  explicit AirDrag(double coefficient);
  std::vector<std::string> names() const override { return {"air_drag"}; }
  void addForces(const Vectors& /*positions*/, const Vectors& velocities,
                 Vectors& forces) const override {
    forces -= coefficient_ * velocities;
  }
  void addForces(const Vectors& positions, const Vectors& velocities, Vectors& forces,
                 Energy& /*energy*/, double& dissipation) const override {
    addForces(positions, velocities, forces);
    dissipation += 0.5 * coefficient_ * velocities.squaredNorm();
  }
  void addForceDerivative(const Vectors& /*x*/, const Vectors& /*v*/, const Vectors& /*dx*/,
                          const Vectors& dv, Vectors& df) const override {
    df -= coefficient_ * dv;
  }
  std::uint32_t addDerivatives(const Vectors& positions, const Vectors& velocities,
                               const MatrixWeights& weights, Projection projection,
                               StepMatrix& matrix) const override;
  std::uint32_t linearize(const Vectors& positions, const Vectors& velocities, double w,
                          StepMatrix& matrix, Vectors& /*forces*/) const override {
    return addDerivatives(positions, velocities, {1.0, w, w * w}, Projection::kWhereNeeded, matrix);
  }
  void addBounds(Eigen::VectorXd& /*stiffness*/, Eigen::VectorXd& damping) const override {
    damping.array() += coefficient_;
  }

 private:
  double coefficient_;
};

}  // namespace mass_spring
