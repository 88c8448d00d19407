#include "grid.h"

#include <algorithm>

namespace mass_spring {

Grid::Grid(const std::array<int, 3>& resolution, const Eigen::Vector3d& size)
    : resolution_(resolution) {
  for (int axis = 0; axis < 3; ++axis) {
    spacing_[axis] = resolution[axis] > 1 ? size[axis] / (resolution[axis] - 1) : 0.0;
  }
}

std::uint32_t Grid::particle(int ix, int iy, int iz) const {
  const auto nx = static_cast<std::uint32_t>(resolution_[0]);
  const auto ny = static_cast<std::uint32_t>(resolution_[1]);
  return (static_cast<std::uint32_t>(iz) * ny + static_cast<std::uint32_t>(iy)) * nx +
         static_cast<std::uint32_t>(ix);
}

Vectors Grid::centeredPositions() const {
  const auto [nx, ny, nz] = resolution_;
  Vectors positions(3, Eigen::Index{nx} * ny * nz);
  for (int iz = 0; iz < nz; ++iz) {
    for (int iy = 0; iy < ny; ++iy) {
      for (int ix = 0; ix < nx; ++ix) {
        const Eigen::Array3d steps(ix - (nx - 1) / 2.0, iy - (ny - 1) / 2.0, iz - (nz - 1) / 2.0);
        positions.col(particle(ix, iy, iz)) = steps * spacing_.array();
      }
    }
  }
  return positions;
}

void Grid::join(const GridOffset& offset, const SpringFamily& family,
                std::vector<Spring>& springs) const {
  const double rest_length =
      (Eigen::Array3d(offset[0], offset[1], offset[2]) * spacing_.array()).matrix().norm();
  std::array<int, 3> begin, end;  // of the particles that have a neighbor at the offset
  for (int axis = 0; axis < 3; ++axis) {
    begin[axis] = std::max(0, -offset[axis]);
    end[axis] = resolution_[axis] - std::max(0, offset[axis]);
  }
  for (int iz = begin[2]; iz < end[2]; ++iz) {
    for (int iy = begin[1]; iy < end[1]; ++iy) {
      for (int ix = begin[0]; ix < end[0]; ++ix) {
        springs.push_back({particle(ix, iy, iz),
                           particle(ix + offset[0], iy + offset[1], iz + offset[2]), rest_length,
                           family.stiffness, family.damping, family.kind});
      }
    }
  }
}

}  // namespace mass_spring
