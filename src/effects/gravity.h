#pragma once

#include "effects/effect.h"

namespace mass_spring {

/// A constant acceleration g: E = -m g . x, f = m g.
class Gravity : public Effect {
 public:
  Gravity(const Eigen::Vector3d& acceleration, const Eigen::VectorXd& masses)
      : weights_(acceleration * masses.transpose()) {}
  std::vector<std::string> names() const override { return {"gravity"}; }
  bool constant() const override { return true; }
  void addEnergy(const Vectors& positions, Energy& energy) const override {
    energy.gravity -= weights_.cwiseProduct(positions).sum();
  }
  void addForces(const Vectors& /*positions*/, const Vectors& /*velocities*/,
                 Vectors& forces) const override {
    forces += weights_;
  }
  void addForces(const Vectors& positions, const Vectors& velocities, Vectors& forces,
                 Energy& energy, double& /*dissipation*/) const override {
    addEnergy(positions, energy);
    addForces(positions, velocities, forces);
  }
  std::uint32_t linearize(const Vectors& positions, const Vectors& velocities, double /*w*/,
                          StepMatrix& /*matrix*/, Vectors& forces) const override {
    addForces(positions, velocities, forces);
    return 0;
  }

 private:
  Vectors weights_;  // N
};

}  // namespace mass_spring
