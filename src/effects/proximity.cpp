#include "effects/proximity.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace mass_spring {
namespace {

// Of the distance at the start: so near is touching. Nothing that moves a little further would stay
// on the same side.
constexpr double kTouching = 1e-3;
// Elements that slide closely along each other come nearer slowly.
constexpr int kMostAdvances = 256;
// Of the squared lengths: below this the sine of two directions, squared, is rounding.
constexpr double kParallel = 1e-12;

Proximity withoutDistance(const Eigen::Vector4d& weights) {
  Proximity near;
  near.weights = weights;
  near.freedoms = 0;
  return near;
}

/// Distance and normal follow from the weights.
Proximity measured(Proximity near, const Corners& x) {
  const Eigen::Vector3d apart = x * near.weights;
  if (near.freedoms == 2) {
    // Exact also where almost nothing is apart; which of the two sides it is, rounding then says.
    const Eigen::Matrix<double, 3, 2> along = x * near.free_weights;
    const Eigen::Vector3d normal = along.col(0).cross(along.col(1)).normalized();
    near.distance = normal.dot(apart);
    near.normal = near.distance < 0.0 ? Eigen::Vector3d(-normal) : normal;
    near.distance = std::abs(near.distance);
    return near;
  }
  near.distance = apart.norm();
  near.normal = near.distance > 0.0 ? Eigen::Vector3d(apart / near.distance)
                                    : Eigen::Vector3d(Eigen::Vector3d::UnitZ());
  return near;
}

/// Where on the segment from particle a to particle b the nearest place to particle 0 is.
double placeOnSide(const Corners& x, int a, int b) {
  const Eigen::Vector3d along = x.col(b) - x.col(a);
  const double square = along.squaredNorm();
  return square > 0.0 ? std::clamp(along.dot(x.col(0) - x.col(a)) / square, 0.0, 1.0) : 0.0;
}

Proximity particleToTriangle(const Corners& x) {
  const Eigen::Vector3d to_b = x.col(2) - x.col(1), to_c = x.col(3) - x.col(1);
  const Eigen::Vector3d to_particle = x.col(0) - x.col(1);
  const double bb = to_b.squaredNorm(), bc = to_b.dot(to_c), cc = to_c.squaredNorm();
  const double pb = to_particle.dot(to_b), pc = to_particle.dot(to_c);
  const double determinant = bb * cc - bc * bc;
  const bool flat = !(determinant > kParallel * bb * cc);
  const double b = (cc * pb - bc * pc) / determinant, c = (bb * pc - bc * pb) / determinant;
  if (!flat && b > 0.0 && c > 0.0 && b + c < 1.0) {
    Proximity near = withoutDistance({1.0, b + c - 1.0, -b, -c});
    near.freedoms = 2;
    near.free_weights.col(0) = Eigen::Vector4d(0.0, 1.0, -1.0, 0.0);
    near.free_weights.col(1) = Eigen::Vector4d(0.0, 1.0, 0.0, -1.0);
    return near;
  }
  // The nearest place lies on a side beyond which the particle is.
  const double inside[3] = {c, 1.0 - b - c, b};  // of the sides 1 2, 2 3, 3 1
  double least = std::numeric_limits<double>::infinity(), at = 0.0;
  int first = 1;
  for (int a = 1; a <= 3; ++a) {
    if (!flat && inside[a - 1] > 0.0) continue;
    const double place = placeOnSide(x, a, a % 3 + 1);
    const double square =
        (x.col(0) - (1.0 - place) * x.col(a) - place * x.col(a % 3 + 1)).squaredNorm();
    if (square >= least) continue;
    least = square;
    first = a;
    at = place;
  }
  const int second = first % 3 + 1;
  Eigen::Vector4d weights = Eigen::Vector4d::UnitX();
  weights[first] = at - 1.0;
  weights[second] = -at;
  Proximity near = withoutDistance(weights);
  if (at > 0.0 && at < 1.0) {
    near.freedoms = 1;
    near.free_weights.col(0) = Eigen::Vector4d::Unit(first) - Eigen::Vector4d::Unit(second);
  }
  return near;
}

// The nearest points of the two lines, moved into the segments one after the other (Ericson,
// "Real-time collision detection", 2005, section 5.1.9).
Proximity segmentToSegment(const Corners& x) {
  const Eigen::Vector3d d1 = x.col(1) - x.col(0), d2 = x.col(3) - x.col(2);
  const Eigen::Vector3d r = x.col(0) - x.col(2);
  const double a = d1.squaredNorm(), e = d2.squaredNorm(), b = d1.dot(d2);
  const double c = d1.dot(r), f = d2.dot(r);
  const double determinant = a * e - b * b;
  const auto onFirst = [&](double u) {
    return a > 0.0 ? std::clamp((b * u - c) / a, 0.0, 1.0) : 0.0;
  };
  // Along parallels one point is as good as any other.
  double s =
      determinant > kParallel * a * e ? std::clamp((b * f - c * e) / determinant, 0.0, 1.0) : 0.0;
  double u = e > 0.0 ? (b * s + f) / e : 0.0;
  bool held = e == 0.0;  // the second point
  if (u < 0.0 || u > 1.0 || held) {
    u = std::clamp(u, 0.0, 1.0);
    s = onFirst(u);
    held = true;
  } else {
    held = u == 0.0 || u == 1.0;
  }
  Proximity near = withoutDistance({1.0 - s, s, u - 1.0, -u});
  if (s > 0.0 && s < 1.0) {
    near.free_weights.col(near.freedoms++) = Eigen::Vector4d(-1.0, 1.0, 0.0, 0.0);
  }
  if (!held) near.free_weights.col(near.freedoms++) = Eigen::Vector4d(0.0, 0.0, 1.0, -1.0);
  return near;
}

/// m, along a direction: how far the first element is above the second one, and below it.
struct Gaps {
  double above, below;
};
/// @param places  of the corners, along the direction
Gaps gaps(Elements elements, const Eigen::RowVector4d& places) {
  const bool segments = elements == Elements::kSegments;
  const double a = places[0], b = places[1], c = places[2], d = places[3];
  const double low1 = segments ? std::min(a, b) : a, high1 = segments ? std::max(a, b) : a;
  const double low2 = segments ? std::min(c, d) : std::min(b, std::min(c, d));
  const double high2 = segments ? std::max(c, d) : std::max(b, std::max(c, d));
  return {low1 - high2, low2 - high1};
}

/// From the middle of the second element to that of the first one.
Eigen::Vector3d betweenMiddles(Elements elements, const Corners& x) {
  if (elements == Elements::kSegments) return 0.5 * (x.col(0) + x.col(1) - x.col(2) - x.col(3));
  return x.col(0) - (x.col(1) + x.col(2) + x.col(3)) / 3.0;
}

}  // namespace

Proximity proximity(Elements elements, const Corners& x) {
  return measured(elements == Elements::kSegments ? segmentToSegment(x) : particleToTriangle(x), x);
}

double leastDistance(Elements elements, const Corners& x) { return leastDistance(elements, x, x); }

// Along a direction, the gap to what is on the other side is a least difference of two corners: on
// the way, it is never below the lesser one of those at the ends.
double leastDistance(Elements elements, const Corners& from, const Corners& to, double enough) {
  double square = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const Gaps before = gaps(elements, from.row(axis)), after = gaps(elements, to.row(axis));
    const double gap = std::max(
        0.0, std::max(std::min(before.above, after.above), std::min(before.below, after.below)));
    square += gap * gap;
  }
  const double between_boxes = std::sqrt(square);
  const Eigen::RowVector3d direction = betweenMiddles(elements, from).transpose();
  if (between_boxes > enough || direction.isZero(0.0)) return between_boxes;
  const double along =
      std::min(gaps(elements, direction * from).above, gaps(elements, direction * to).above);
  return std::max(between_boxes, along / direction.norm());
}

// Nearest points are apart across the free directions E = X C: with r = X w, E^T r = 0 at all
// times, so that E^T (dX w + E db) = -dE^T r for dw = C db.
ProximityRate rate(const Proximity& near, const Corners& x, const Corners& dx) {
  const Eigen::Vector3d moved = dx * near.weights;
  ProximityRate change{Eigen::Vector4d::Zero(), Eigen::Vector3d::Zero()};
  const auto across = [&](const Eigen::Vector3d& v) {
    return Eigen::Vector3d(v - near.normal.dot(v) * near.normal);
  };
  if (near.freedoms == 2) {
    const Eigen::Matrix<double, 3, 2> along = x * near.free_weights;
    const Eigen::Matrix2d inverse = (along.transpose() * along).inverse();
    const Eigen::Vector2d turned = (dx * near.free_weights).transpose() * near.normal;
    change.weights =
        -near.free_weights * (inverse * (near.distance * turned + along.transpose() * moved));
    change.normal = -along * (inverse * turned);  // it stays across both
    return change;
  }
  Eigen::Vector3d apart = moved;
  if (near.freedoms == 1) {
    const Eigen::Vector4d free = near.free_weights.col(0);
    const Eigen::Vector3d along = x * free;
    const double step =
        -(near.distance * near.normal.dot(dx * free) + along.dot(moved)) / along.squaredNorm();
    change.weights = step * free;
    apart += step * along;
  }
  if (near.distance > 0.0) change.normal = across(apart) / near.distance;
  return change;
}

double mostApproach(Elements elements, const Corners& dx) {
  double square = 0.0;
  if (elements == Elements::kSegments) {
    for (const int a : {0, 1}) {
      for (const int b : {2, 3}) square = std::max(square, (dx.col(a) - dx.col(b)).squaredNorm());
    }
  } else {
    for (const int b : {1, 2, 3}) square = std::max(square, (dx.col(0) - dx.col(b)).squaredNorm());
  }
  return std::sqrt(square);
}

bool changesSides(const Corners& from, const Corners& to) {
  const auto volume = [](const Corners& x) {
    return (x.col(1) - x.col(0)).dot((x.col(2) - x.col(0)).cross(x.col(3) - x.col(0)));
  };
  return (volume(from) < 0.0) != (volume(to) < 0.0);
}

std::optional<Proximity> firstTouch(Elements elements, const Corners& from, const Corners& to) {
  const Corners way = to - from;
  const double approach = mostApproach(elements, way);
  Proximity near = proximity(elements, from);
  const double touching = kTouching * near.distance;
  double at = 0.0;
  for (int advance = 0; advance < kMostAdvances; ++advance) {
    if (near.distance <= touching) {
      if (advance == 0) return std::nullopt;  // it has no side to be on
      return near;
    }
    at += (near.distance - 0.5 * touching) / approach;
    if (!(at < 1.0)) return std::nullopt;
    near = proximity(elements, from + at * way);
  }
  return std::nullopt;
}

}  // namespace mass_spring
