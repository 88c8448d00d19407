#pragma once

#include "effects/effect.h"

namespace mass_spring {

/// Still air that brakes each particle alike: f = -c v, Q = c |v|^2 / 2, D = c I.
class AirDrag : public Effect {
 public:
  /// @param coefficient  N s/m per particle, >= 0
  explicit AirDrag(double coefficient) : Effect(Traits{{"air_drag"}}), coefficient_(coefficient) {}
  void add(const Point& point, Scratch* /*scratch*/, const Sums& sums) const override {
    if (sums.forces) *sums.forces -= coefficient_ * point.velocities;
    if (sums.dissipation) *sums.dissipation += 0.5 * coefficient_ * point.velocities.squaredNorm();
  }
  void addForceDerivative(const Point& /*point*/, Scratch* /*scratch*/, const Vectors& /*dx*/,
                          const Vectors& dv, Vectors& df) const override {
    df -= coefficient_ * dv;
  }
  std::uint32_t addDerivatives(const Point& point, Scratch* scratch, const MatrixWeights& weights,
                               Projection projection, StepMatrix& matrix) const override;
  std::uint32_t linearize(const Point& point, Scratch* scratch, double w, StepMatrix& matrix,
                          Vectors& /*forces*/) const override {
    return addDerivatives(point, scratch, {1.0, w, w * w}, Projection::kWhereNeeded, matrix);
  }
  void addBounds(Eigen::VectorXd& /*stiffness*/, Eigen::VectorXd& damping) const override {
    damping.array() += coefficient_;
  }

 private:
  double coefficient_;
};

}  // namespace mass_spring
