#include "passages.h"

#include <Eigen/Dense>
#include <algorithm>

namespace mass_spring {
namespace {

using Four = std::array<std::uint32_t, 4>;

/// Are the four points of a plane, found where the volume is zero, in each other's way?
bool meet(const Eigen::Matrix<double, 3, 4>& x, bool segments) {
  if (segments) {
    // a + s (b - a) = c + u (d - c) in the plane.
    Eigen::Matrix<double, 3, 2> ways;
    ways << x.col(1) - x.col(0), x.col(2) - x.col(3);
    const Eigen::Vector2d at = ways.colPivHouseholderQr().solve(x.col(2) - x.col(0));
    return (at.array() > 0.0).all() && (at.array() < 1.0).all();
  }
  Eigen::Matrix<double, 3, 2> sides;
  sides << x.col(2) - x.col(1), x.col(3) - x.col(1);
  const Eigen::Vector2d at = sides.colPivHouseholderQr().solve(x.col(0) - x.col(1));
  return (at.array() > 0.0).all() && at.sum() < 1.0;
}

bool passes(const Vectors& from, const Vectors& to, const Four& four, bool segments) {
  const auto corners = [&](double at) {
    Eigen::Matrix<double, 3, 4> x;
    for (int a = 0; a < 4; ++a) {
      const std::uint32_t i = four[static_cast<std::size_t>(a)];
      x.col(a) = (1.0 - at) * from.col(i) + at * to.col(i);
    }
    return x;
  };
  const auto volume = [&](double at) {
    const Eigen::Matrix<double, 3, 4> x = corners(at);
    return (x.col(1) - x.col(0)).dot((x.col(2) - x.col(0)).cross(x.col(3) - x.col(0)));
  };
  if ((volume(0.0) < 0.0) == (volume(1.0) < 0.0)) return false;
  double low = 0.0, high = 1.0;
  for (int halving = 0; halving < 50; ++halving) {
    const double middle = 0.5 * (low + high);
    ((volume(low) < 0.0) == (volume(middle) < 0.0) ? low : high) = middle;
  }
  return meet(corners(low), segments);
}

bool share(const Four& four) {
  for (std::size_t a = 0; a < 4; ++a) {
    for (std::size_t b = a + 1; b < 4; ++b) {
      if (four[a] == four[b]) return true;
    }
  }
  return false;
}

}  // namespace

int passages(const Model& model, const Vectors& from, const Vectors& to) {
  int count = 0;
  const auto look = [&](const Four& four, bool segments) {
    if (!share(four) && passes(from, to, four, segments)) ++count;
  };
  for (std::uint32_t i = 0; i < model.particleCount(); ++i) {
    for (const auto& t : model.triangles) look({i, t[0], t[1], t[2]}, false);
  }
  std::vector<std::array<std::uint32_t, 2>> segments;
  for (const Spring& s : model.springs) {
    const bool single = s.kind == SpringKind::kStructural && !model.objectOf(s.i).has_surface;
    if (single) segments.push_back({s.i, s.j});
  }
  for (std::size_t a = 0; a < segments.size(); ++a) {
    for (std::size_t b = a + 1; b < segments.size(); ++b) {
      look({segments[a][0], segments[a][1], segments[b][0], segments[b][1]}, true);
    }
  }
  return count;
}

}  // namespace mass_spring
