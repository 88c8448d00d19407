#include "grid.h"
#include "object_parts.h"

namespace mass_spring {

ObjectParts buildParts(const Cloth& cloth) {
  const auto [columns, rows] = cloth.resolution;
  const Grid grid({columns, rows, 1}, {cloth.size.x(), cloth.size.y(), 0.0});
  ObjectParts parts = partsAtRest(
      (rotation(cloth.orientation) * grid.centeredPositions()).colwise() + cloth.position,
      cloth.mass);

  const double damping = cloth.damping.value_or(0.0);
  const SpringFamily structural{SpringKind::kStructural, cloth.stiffness, damping};
  grid.join({1, 0, 0}, structural, parts.springs);
  grid.join({0, 1, 0}, structural, parts.springs);
  if (cloth.shear_stiffness) {
    const SpringFamily shear{SpringKind::kShear, *cloth.shear_stiffness, damping};
    grid.join({1, 1, 0}, shear, parts.springs);
    grid.join({-1, 1, 0}, shear, parts.springs);
  }
  if (cloth.bend_stiffness) {
    const SpringFamily bending{SpringKind::kBending, *cloth.bend_stiffness, damping};
    grid.join({2, 0, 0}, bending, parts.springs);
    grid.join({0, 2, 0}, bending, parts.springs);
  }

  for (int row = 0; row + 1 < rows; ++row) {
    for (int column = 0; column + 1 < columns; ++column) {
      // Counterclockwise seen from above: normals point along +z of the object.
      const std::uint32_t a = grid.particle(column, row, 0);
      const std::uint32_t b = grid.particle(column + 1, row, 0);
      const std::uint32_t c = grid.particle(column + 1, row + 1, 0);
      const std::uint32_t d = grid.particle(column, row + 1, 0);
      parts.triangles.push_back({a, b, c});
      parts.triangles.push_back({a, c, d});
    }
  }
  return parts;
}

}  // namespace mass_spring
