#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "mass_spring_sim/rigid_motion.h"

namespace mass_spring {

/// 3 x n, one column per particle: x0 y0 z0 x1 y1 z1 ... in memory.
using Vectors = Eigen::Matrix3Xd;

/// The memory of the effects from step to step.
struct EffectState {
  std::vector<double> rest_lengths;  ///< m, by Spring::number; empty = all as built
  std::vector<char> broken;          ///< by Spring::number; empty = none is
  std::vector<RigidMotion> shapes;   ///< of the model's shapes, in their order

  bool operator==(const EffectState& other) const {
    return rest_lengths == other.rest_lengths && broken == other.broken && shapes == other.shapes;
  }
};

/// Everything that changes while a model steps, but for pins and forces, which come from outside. A
/// plain value, which can be copied and compared.
struct State {
  std::uint64_t step = 0;  ///< steps since start or reset
  double time = 0.0;       ///< s, step / rate
  Vectors positions;       ///< m
  Vectors velocities;      ///< m/s
  EffectState effects;

  bool operator==(const State& other) const {
    const auto same = [](const Vectors& a, const Vectors& b) {
      return a.cols() == b.cols() && a == b;
    };
    return step == other.step && time == other.time && same(positions, other.positions) &&
           same(velocities, other.velocities) && effects == other.effects;
  }
};

}  // namespace mass_spring
