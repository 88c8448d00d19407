#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "mass_spring_sim/model.h"

namespace mass_spring {

/// Offset between two particles of a grid, in cells along x, y and z.
using GridOffset = std::array<int, 3>;

/// What the springs of one family have in common.
struct SpringFamily {
  SpringKind kind;
  double stiffness;  ///< N/m
  double damping;    ///< N s/m
};

/// Regular arrangement of particles that ropes (n x 1 x 1), cloth (n x m x 1) and lattices share;
/// particle = (iz * ny + iy) * nx + ix.
class Grid {
 public:
  /// @param resolution  particles along each axis, >= 1
  /// @param size        m, from the first particle to the last along each axis
  Grid(const std::array<int, 3>& resolution, const Eigen::Vector3d& size);

  std::uint32_t particle(int ix, int iy, int iz) const;

  /// 3 x n, centered on the origin [m].
  Vectors centeredPositions() const;

  /// Joins every particle with the one at `offset` from it, where there is one. The offset's last
  /// component that is not 0 is positive, so that no pair is met twice. All springs get the same
  /// rest length, that of the undistorted grid: no rounding of positions enters it.
  void join(const GridOffset& offset, const SpringFamily& family,
            std::vector<Spring>& springs) const;

 private:
  std::array<int, 3> resolution_;
  Eigen::Vector3d spacing_;  // m
};

}  // namespace mass_spring
