#include <initializer_list>

#include "grid.h"
#include "object_parts.h"

namespace mass_spring {

ObjectParts buildParts(const Lattice& lattice) {
  const Grid grid(lattice.resolution, lattice.size);
  ObjectParts parts = partsAtRest(
      (rotation(lattice.orientation) * grid.centeredPositions()).colwise() + lattice.position,
      lattice.mass);

  const double damping = lattice.damping.value_or(0.0);
  const auto joinAll = [&](std::initializer_list<GridOffset> offsets, SpringKind kind,
                           double stiffness) {
    for (const GridOffset& offset : offsets) {
      grid.join(offset, {kind, stiffness, damping}, parts.springs);
    }
  };
  joinAll({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, SpringKind::kStructural, lattice.stiffness);
  if (lattice.shear_stiffness) {
    joinAll({{1, 1, 0},
             {-1, 1, 0},
             {1, 0, 1},
             {-1, 0, 1},
             {0, 1, 1},
             {0, -1, 1},  // of faces
             {1, 1, 1},
             {-1, 1, 1},
             {1, -1, 1},
             {-1, -1, 1}},  // of the body
            SpringKind::kShear, *lattice.shear_stiffness);
  }
  if (lattice.bend_stiffness) {
    joinAll({{2, 0, 0}, {0, 2, 0}, {0, 0, 2}}, SpringKind::kBending, *lattice.bend_stiffness);
  }
  return parts;
}

}  // namespace mass_spring
