#include "effects/broad_phase.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mass_spring {
namespace {

// Of the distance: a smaller one is used up sooner, a larger one lets in more pairs.
constexpr double kMargin = 0.25;

template <std::size_t N, std::size_t M>
bool shareParticle(const std::array<std::uint32_t, N>& a, const std::array<std::uint32_t, M>& b) {
  return std::any_of(a.begin(), a.end(), [&](std::uint32_t particle) {
    return std::find(b.begin(), b.end(), particle) != b.end();
  });
}

template <std::size_t N>
Vectors centers(const std::vector<std::array<std::uint32_t, N>>& elements, const Vectors& x) {
  Vectors sums = Vectors::Zero(3, static_cast<Eigen::Index>(elements.size()));
  for (std::size_t e = 0; e < elements.size(); ++e) {
    for (const std::uint32_t i : elements[e]) sums.col(static_cast<Eigen::Index>(e)) += x.col(i);
  }
  return sums / static_cast<double>(N);
}

}  // namespace

CollisionElements::CollisionElements(const Model& model)
    : triangles(model.triangles), object(model.particleCount()), rest(model.start.positions) {
  std::vector<char> joined(model.particleCount(), 0);
  for (std::uint32_t o = 0; o < model.objects.size(); ++o) {
    const ModelObject& part = model.objects[o];
    std::fill_n(object.begin() + part.first_particle, part.particle_count, o);
    std::fill_n(joined.begin() + part.first_particle, part.particle_count, part.has_surface);
    if (part.has_surface) continue;
    for (std::uint32_t s = part.first_spring; s < part.first_spring + part.spring_count; ++s) {
      const Spring& spring = model.springs[s];
      if (spring.kind != SpringKind::kStructural) continue;
      edges.push_back({spring.i, spring.j});
      joined[spring.i] = joined[spring.j] = 1;
    }
  }
  for (std::uint32_t i = 0; i < joined.size(); ++i) {
    if (!joined[i]) edges.push_back({i, i});
  }
  segments = edges.size();
  if (segments == 0) return;
  std::vector<std::array<std::uint32_t, 2>> sides;
  for (const auto& corners : triangles) {
    for (std::size_t a = 0; a < 3; ++a) {
      const std::uint32_t i = corners[a], j = corners[(a + 1) % 3];
      sides.push_back({std::min(i, j), std::max(i, j)});
    }
  }
  std::sort(sides.begin(), sides.end());
  sides.erase(std::unique(sides.begin(), sides.end()), sides.end());
  edges.insert(edges.end(), sides.begin(), sides.end());
}

BroadPhase::BroadPhase(const CollisionElements& elements, double distance, ThreadPool& threads)
    : elements_(elements),
      distance_(distance),
      margin_(kMargin * distance),
      threads_(threads),
      triangles_(centers(elements_.triangles, elements_.rest)),
      edges_(centers(elements_.edges, elements_.rest)) {}

double BroadPhase::strayed(const Vectors& positions) const {
  if (from_.cols() != positions.cols()) return std::numeric_limits<double>::infinity();
  const auto n = static_cast<double>(positions.cols());
  // How far along their ways they are, by least squares about the common motion.
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double along = 0.0, square = 0.0;
  for (Eigen::Index i = 0; i < positions.cols(); ++i) {
    const Eigen::Vector3d moved = positions.col(i) - from_.col(i);
    const Eigen::Vector3d way = way_.col(i) - mean_way_;
    sum += moved;
    along += moved.dot(way);
    square += way.squaredNorm();
  }
  const double at = square > 0.0 ? std::clamp(along / square, 0.0, 1.0) : 0.0;
  const Eigen::Vector3d common = sum / n - at * mean_way_;
  double furthest = 0.0;
  for (Eigen::Index i = 0; i < positions.cols(); ++i) {
    const Eigen::Vector3d off = positions.col(i) - from_.col(i) - at * way_.col(i) - common;
    const double off_square = off.squaredNorm();
    if (!(off_square <= furthest)) furthest = off_square;  // keeps what is not a number
  }
  return std::sqrt(furthest);
}

template <std::size_t N>
AlignedBox BroadPhase::box(const std::array<std::uint32_t, N>& particles) const {
  AlignedBox hull = AlignedBox::empty();
  const double reach = 0.5 * distance_ + margin_;
  for (const std::uint32_t i : particles) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto row = static_cast<Eigen::Index>(axis);
      const double start = from_(row, i), end = start + way_(row, i) - mean_way_[row];
      hull.low[axis] = std::min(hull.low[axis], std::min(start, end) - reach);
      hull.high[axis] = std::max(hull.high[axis], std::max(start, end) + reach);
    }
  }
  return hull;
}

void BroadPhase::take(std::array<std::uint32_t, 4> particles, Elements elements,
                      Found& found) const {
  ElementPair pair{particles, elements, 0.0};
  const double reach = distance_ + 2.0 * margin_;
  pair.apart = leastDistance(elements, pair.corners(from_), pair.corners(to_), reach);
  if (!(pair.apart <= reach)) return;
  const auto& object = elements_.object;
  if (object[particles[0]] == object[particles[2]]) {
    const Corners rest = pair.corners(elements_.rest);
    if (leastDistance(elements, rest) < distance_ &&
        proximity(elements, rest).distance < distance_) {
      return;
    }
  }
  found.pairs.push_back(pair);
}

void BroadPhase::findRoundParticle(std::uint32_t i, Found& found) const {
  const std::array<std::uint32_t, 1> particle{i};
  triangles_.find(box(particle), found.boxes);
  for (const std::uint32_t t : found.boxes) {
    const auto& [a, b, c] = elements_.triangles[t];
    if (shareParticle(particle, elements_.triangles[t])) continue;
    take({i, a, b, c}, Elements::kParticleAndTriangle, found);
  }
}

void BroadPhase::findRoundSegment(std::uint32_t s, Found& found) const {
  const auto& edges = elements_.edges;
  edges_.find(boxes_[s], found.boxes);
  for (const std::uint32_t e : found.boxes) {
    if (e <= s || shareParticle(edges[s], edges[e])) continue;
    take({edges[s][0], edges[s][1], edges[e][0], edges[e][1]}, Elements::kSegments, found);
  }
}

template <typename Find>
void BroadPhase::findPairs(std::size_t elements, const Find& find) {
  threads_.run(kParts, [&](std::uint32_t part) {
    Found& found = found_[part];
    found.pairs.clear();
    for (std::size_t e = part * elements / kParts; e < (part + 1) * elements / kParts; ++e) {
      find(static_cast<std::uint32_t>(e), found);
    }
  });
  for (const Found& found : found_) {
    pairs_.insert(pairs_.end(), found.pairs.begin(), found.pairs.end());
  }
}

void BroadPhase::refresh(const Vectors& from, const Vectors& to) {
  from_ = from;
  to_ = to;
  way_ = to - from;
  mean_way_ = way_.rowwise().mean();
  pairs_.clear();
  const auto fit = [&](const auto& elements, BoxTree& tree) {
    boxes_.clear();
    for (const auto& particles : elements) boxes_.push_back(box(particles));
    tree.fit(boxes_);
  };
  if (!elements_.triangles.empty()) {
    fit(elements_.triangles, triangles_);
    findPairs(elements_.object.size(),
              [this](std::uint32_t i, Found& found) { findRoundParticle(i, found); });
  }
  if (elements_.segments == 0) return;
  fit(elements_.edges, edges_);
  findPairs(elements_.segments,
            [this](std::uint32_t s, Found& found) { findRoundSegment(s, found); });
}

}  // namespace mass_spring
