#pragma once

#include <Eigen/Core>

namespace mass_spring {

/// Length and unit direction of a spring from x_j - x_i. Where the two coincide there is no
/// direction; z stands in, so that the ends part the same way on every run.
struct SpringDirection {
  double length;      ///< m
  Eigen::Vector3d n;  ///< from i to j

  explicit SpringDirection(const Eigen::Vector3d& d) : length(d.norm()) {
    n = length > 0.0 ? Eigen::Vector3d(d / length) : Eigen::Vector3d::UnitZ();
  }
};

}  // namespace mass_spring
