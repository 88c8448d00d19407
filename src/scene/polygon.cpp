#include "scene/polygon.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace mass_spring {
namespace {

using Corners = std::vector<std::uint32_t>;
using Triangle = std::array<std::uint32_t, 3>;

// Of two diagonals that differ by rounding alone, the second is taken, whatever the rounding.
constexpr double kShorter = 1.0 - 1e-6;

/// A polygon, seen along its normal, around which its corners turn counterclockwise.
class Outline {
 public:
  Outline(const std::vector<Eigen::Vector3d>& vertices, const Corners& corners)
      : vertices_(vertices) {
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // twice the area, by Newell's formula
    const Eigen::Vector3d& origin = vertices[corners[0]];
    for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
      normal += (vertices[corners[i]] - origin).cross(vertices[corners[i + 1]] - origin);
    }
    // The coordinate that is left out is the one along which the outline is seen.
    Eigen::Index along = 0;
    normal.cwiseAbs().maxCoeff(&along);
    u_ = (along + 1) % 3;
    v_ = (along + 2) % 3;
    if (normal[along] < 0.0) std::swap(u_, v_);
  }

  /// Twice the area of a triangle; negative if it turns clockwise.
  double area(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    const Eigen::Vector3d ab = vertices_[b] - vertices_[a], ac = vertices_[c] - vertices_[a];
    return ab[u_] * ac[v_] - ab[v_] * ac[u_];
  }

  /// Whether corner i can be cut off: nothing of the rest lies in its triangle.
  bool isEar(const Corners& corners, std::size_t i) const {
    const auto [a, b, c] = triangleAt(corners, i);
    if (!(area(a, b, c) > 0.0)) return false;
    for (const std::uint32_t other : corners) {
      const Eigen::Vector3d& p = vertices_[other];
      if (p == vertices_[a] || p == vertices_[b] || p == vertices_[c]) continue;
      if (area(a, b, other) >= 0.0 && area(b, c, other) >= 0.0 && area(c, a, other) >= 0.0) {
        return false;
      }
    }
    return true;
  }

  static Triangle triangleAt(const Corners& corners, std::size_t i) {
    const std::size_t count = corners.size();
    return {corners[(i + count - 1) % count], corners[i], corners[(i + 1) % count]};
  }

 private:
  const std::vector<Eigen::Vector3d>& vertices_;
  Eigen::Index u_, v_;
};

}  // namespace

std::vector<Triangle> cutPolygon(const std::vector<Eigen::Vector3d>& vertices, Corners corners) {
  if (corners.size() == 3) return {{corners[0], corners[1], corners[2]}};
  const Outline outline(vertices, corners);
  if (corners.size() == 4) {
    const auto [a, b, c, d] =
        std::array<std::uint32_t, 4>{corners[0], corners[1], corners[2], corners[3]};
    const double ac = (vertices[c] - vertices[a]).squaredNorm();
    const double bd = (vertices[d] - vertices[b]).squaredNorm();
    const bool along_ac = ac < bd * kShorter;
    // Both triangles have an area unless the corner beside the diagonal is concave.
    if (along_ac && outline.area(a, b, c) > 0.0 && outline.area(a, c, d) > 0.0) {
      return {{a, b, c}, {a, c, d}};
    }
    if (!along_ac && outline.area(a, b, d) > 0.0 && outline.area(b, c, d) > 0.0) {
      return {{a, b, d}, {b, c, d}};
    }
  }
  std::vector<Triangle> triangles;
  while (corners.size() >= 3) {
    std::size_t ear = 0;
    while (ear < corners.size() && !outline.isEar(corners, ear)) ++ear;
    if (ear == corners.size()) break;
    triangles.push_back(Outline::triangleAt(corners, ear));
    corners.erase(corners.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  return triangles;
}

}  // namespace mass_spring
