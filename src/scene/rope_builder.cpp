#include <utility>

#include "grid.h"
#include "object_parts.h"

namespace mass_spring {

ObjectParts buildParts(const Rope& rope) {
  const double length = (rope.end - rope.start).norm();
  Vectors positions(3, rope.segments + 1);
  for (int i = 0; i <= rope.segments; ++i) {
    // Weights that are exactly 0 and 1 at the ends put the last particle exactly on `end`.
    const double t = static_cast<double>(i) / rope.segments;
    positions.col(i) = (1.0 - t) * rope.start + t * rope.end;
  }
  ObjectParts parts = partsAtRest(std::move(positions), rope.mass);

  const Grid grid({rope.segments + 1, 1, 1}, {length, 0.0, 0.0});
  const double damping = rope.damping.value_or(0.0);
  // A force F strains a segment of length L by F / EA, that is, lengthens it by F L / EA.
  const double stiffness =
      rope.stiffness ? *rope.stiffness : *rope.axial_rigidity * rope.segments / length;
  grid.join({1, 0, 0}, {SpringKind::kStructural, stiffness, damping}, parts.springs);
  if (rope.bend_stiffness) {
    grid.join({2, 0, 0}, {SpringKind::kBending, *rope.bend_stiffness, damping}, parts.springs);
  }
  return parts;
}

}  // namespace mass_spring
