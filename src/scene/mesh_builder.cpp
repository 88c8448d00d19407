#include <algorithm>
#include <utility>

#include "object_parts.h"

namespace mass_spring {
namespace {

/// A side of a triangle, from the lower particle to the higher, and the corner across from it.
struct Side {
  std::uint32_t low, high, opposite;
};

/// The sides of all triangles, those of the same edge next to one another, in the order of their
/// particles. A triangle that has a corner twice has fewer sides.
std::vector<Side> sortedSides(const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (const auto& corners : triangles) {
    for (int k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(corners[k], corners[(k + 1) % 3]);
      if (low != high) sides.push_back({low, high, corners[(k + 2) % 3]});
    }
  }
  const auto key = [](const Side& side) {
    return std::array<std::uint32_t, 3>{side.low, side.high, side.opposite};
  };
  std::sort(sides.begin(), sides.end(),
            [&](const Side& a, const Side& b) { return key(a) < key(b); });
  return sides;
}

}  // namespace

ObjectParts buildParts(const Mesh& mesh) {
  Vectors positions(3, static_cast<Eigen::Index>(mesh.vertices.size()));
  const Eigen::Matrix3d scaled_rotation = mesh.scale * rotation(mesh.orientation);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    positions.col(i) = scaled_rotation * mesh.vertices[i] + mesh.position;
  }
  ObjectParts parts = partsAtRest(std::move(positions), mesh.mass);
  parts.triangles = mesh.triangles;

  const auto join = [&](std::uint32_t i, std::uint32_t j, double stiffness, SpringKind kind,
                        std::vector<Spring>& springs) {
    const double rest_length = mesh.scale * (mesh.vertices[j] - mesh.vertices[i]).norm();
    springs.push_back({i, j, rest_length, stiffness, mesh.damping.value_or(0.0), kind});
  };
  std::vector<Spring> bending;
  const std::vector<Side> sides = sortedSides(mesh.triangles);
  for (auto edge = sides.begin(); edge != sides.end();) {
    const auto edge_end = std::find_if(edge, sides.end(), [&](const Side& side) {
      return side.low != edge->low || side.high != edge->high;
    });
    join(edge->low, edge->high, mesh.stiffness, SpringKind::kStructural, parts.springs);
    if (mesh.bend_stiffness) {
      // Where more than two triangles meet in an edge, each two of them are adjacent. Two copies of
      // one triangle share their opposite corner: there is nothing to hold apart.
      for (auto a = edge; a != edge_end; ++a) {
        for (auto b = a + 1; b != edge_end; ++b) {
          if (a->opposite == b->opposite) continue;
          join(a->opposite, b->opposite, *mesh.bend_stiffness, SpringKind::kBending, bending);
        }
      }
    }
    edge = edge_end;
  }
  parts.springs.insert(parts.springs.end(), bending.begin(), bending.end());
  return parts;
}

}  // namespace mass_spring
