#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace mass_spring {

/// 3 x n, one column per particle: x0 y0 z0 x1 y1 z1 ... in memory.
using Vectors = Eigen::Matrix3Xd;

/// Everything that changes while a model steps. A plain value, which can be copied and compared.
struct State {
  std::uint64_t step = 0;  ///< steps since start or reset
  double time = 0.0;       ///< s, step / rate
  Vectors positions;       ///< m
  Vectors velocities;      ///< m/s
};

}  // namespace mass_spring
