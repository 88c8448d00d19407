#pragma once

#include "effects/effect.h"

namespace mass_spring {

/// A constant acceleration g: E = -m g . x, f = m g.
class Gravity : public Effect {
 public:
  Gravity(const Eigen::Vector3d& acceleration, const Eigen::VectorXd& masses)
      : Effect(Traits{{"gravity"}, true}), weights_(acceleration * masses.transpose()) {}
  void add(const Point& point, Scratch* /*scratch*/, const Sums& sums) const override {
    if (sums.energy) sums.energy->gravity -= weights_.cwiseProduct(point.positions).sum();
    if (sums.forces) *sums.forces += weights_;
  }
  std::uint32_t linearize(const Point& /*point*/, Scratch* /*scratch*/, double /*w*/,
                          StepMatrix& /*matrix*/, Vectors& forces) const override {
    forces += weights_;
    return 0;
  }

 private:
  Vectors weights_;  // N
};

}  // namespace mass_spring
