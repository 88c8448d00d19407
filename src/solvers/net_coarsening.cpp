#include "solvers/net_coarsening.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <limits>
#include <numeric>
#include <queue>
#include <tuple>

namespace mass_spring {
namespace {

// In spacings. Of a square grid with diagonals this picks every other particle in both directions:
// next along its axes lies 1, along its diagonals 1.41, and 2 is taken again.
constexpr double kCovered = 1.9;
constexpr double kReach = 2.1;  // how far a coarse particle takes part in the interpolation
constexpr std::size_t kMostWeights = 6;
constexpr double kManyNeighbors = 4.0;  // times the mean

struct Way {
  std::uint32_t to;
  double length;
};
using Ways = std::vector<std::vector<Way>>;

Ways waysOf(const Net& net) {
  Ways ways(net.size);
  for (const Net::Pair& pair : net.pairs) {
    ways[pair.i].push_back({pair.j, pair.length});
    ways[pair.j].push_back({pair.i, pair.length});
  }
  return ways;
}

/// Mean of the two shortest ways from a particle: diagonals and bending springs do not count.
double spacing(const std::vector<Way>& ways) {
  double shortest = std::numeric_limits<double>::infinity(), second = shortest;
  for (const Way& way : ways) {
    second = std::min(second, std::max(shortest, way.length));
    shortest = std::min(shortest, way.length);
  }
  return ways.size() > 1 ? 0.5 * (shortest + second) : shortest;
}

/// Visits the particles within a reach of one, nearest first (Dijkstra).
class Surroundings {
 public:
  explicit Surroundings(const Ways& ways)
      : ways_(ways), distance_(ways.size(), std::numeric_limits<double>::infinity()) {}

  template <typename Visit>
  void visit(std::uint32_t from, double reach, const Visit& visit) {
    std::vector<std::uint32_t> touched{from};
    std::priority_queue<Step, std::vector<Step>, std::greater<>> queue;
    distance_[from] = 0.0;
    queue.emplace(0.0, from);
    while (!queue.empty()) {
      const auto [distance, at] = queue.top();
      queue.pop();
      if (distance > distance_[at]) continue;
      visit(at, distance);
      for (const Way& way : ways_[at]) {
        const double there = distance + way.length;
        if (there > reach || there >= distance_[way.to]) continue;
        distance_[way.to] = there;
        touched.push_back(way.to);
        queue.emplace(there, way.to);
      }
    }
    for (const std::uint32_t particle : touched) {
      distance_[particle] = std::numeric_limits<double>::infinity();
    }
  }

 private:
  using Step = std::pair<double, std::uint32_t>;
  const Ways& ways_;
  std::vector<double> distance_;
};

/// A coarse particle near a fine one.
struct Anchor {
  std::uint32_t coarse;
  double distance;
};

std::vector<std::uint32_t> orderOfChoice(const Ways& ways, std::size_t pairs) {
  std::vector<std::uint32_t> order(ways.size());
  std::iota(order.begin(), order.end(), 0u);
  const double many = kManyNeighbors * 2.0 * static_cast<double>(pairs) /
                      static_cast<double>(std::max<std::size_t>(ways.size(), 1));
  std::stable_partition(order.begin(), order.end(), [&](std::uint32_t i) {
    return static_cast<double>(ways[i].size()) > many;
  });
  return order;
}

/// Weights by inverse distance, then w_k = u_k (1 - c_k) with the smallest c that moves their
/// center onto the particle; as far as no weight turns negative.
std::vector<double> weightsOf(const std::vector<Anchor>& anchors, const Vectors& offsets) {
  std::vector<double> weights;
  double sum = 0.0;
  for (const Anchor& anchor : anchors) sum += 1.0 / anchor.distance;
  for (const Anchor& anchor : anchors) weights.push_back(1.0 / (anchor.distance * sum));
  if (offsets.cols() == 0) return weights;

  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < anchors.size(); ++k) center += weights[k] * offsets.col(k);
  for (std::size_t k = 0; k < anchors.size(); ++k) {
    const Eigen::Vector3d d = offsets.col(k) - center;
    spread += weights[k] * d * d.transpose();
  }
  // Along directions in which the anchors hardly spread nothing can be corrected.
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
  const double least = 1e-3 * std::max(axes.eigenvalues()[2], 1e-3 * center.squaredNorm());
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    const double width = axes.eigenvalues()[axis];
    const Eigen::Vector3d direction = axes.eigenvectors().col(axis);
    if (width > least) shift += direction.dot(center) / width * direction;
  }
  double share = 1.0;
  for (std::size_t k = 0; k < anchors.size(); ++k) {
    share = std::min(share, 1.0 / std::max(1.0, (offsets.col(k) - center).dot(shift)));
  }
  for (std::size_t k = 0; k < anchors.size(); ++k) {
    weights[k] *= 1.0 - share * (offsets.col(k) - center).dot(shift);
  }
  return weights;
}

}  // namespace

Interpolation coarsen(Net& net) {
  const Ways ways = waysOf(net);
  Surroundings surroundings(ways);
  std::vector<char> covered(net.size, 0);
  std::vector<std::vector<Anchor>> anchors(net.size);
  std::vector<std::uint32_t> chosen;
  for (const std::uint32_t i : orderOfChoice(ways, net.pairs.size())) {
    if (covered[i] || ways[i].empty()) continue;
    const double s = spacing(ways[i]);
    const auto coarse = static_cast<std::uint32_t>(chosen.size());
    chosen.push_back(i);
    surroundings.visit(i, kReach * s, [&](std::uint32_t at, double distance) {
      if (distance < kCovered * s) covered[at] = 1;
      anchors[at].push_back({coarse, distance});
    });
  }

  Interpolation result;
  result.coarse_size = static_cast<std::uint32_t>(chosen.size());
  Vectors offsets;
  for (std::uint32_t i = 0; i < net.size; ++i) {
    std::vector<Anchor>& near = anchors[i];
    std::stable_sort(near.begin(), near.end(),
                     [](const Anchor& a, const Anchor& b) { return a.distance < b.distance; });
    if (near.size() > kMostWeights) near.resize(kMostWeights);
    if (!near.empty() && near[0].distance == 0.0) {
      near.resize(1);
      result.entries.push_back({near[0].coarse, 1.0f});
    } else if (!near.empty()) {
      offsets.resize(3, net.positions.cols() > 0 ? static_cast<Eigen::Index>(near.size()) : 0);
      for (Eigen::Index k = 0; k < offsets.cols(); ++k) {
        offsets.col(k) = net.positions.col(chosen[near[static_cast<std::size_t>(k)].coarse]) -
                         net.positions.col(i);
      }
      const std::vector<double> weights = weightsOf(near, offsets);
      for (std::size_t k = 0; k < near.size(); ++k) {
        result.entries.push_back({near[k].coarse, static_cast<float>(weights[k])});
      }
    }
    result.start.push_back(static_cast<std::uint32_t>(result.entries.size()));
  }

  Net coarse;
  coarse.size = result.coarse_size;
  for (const Net::Pair& pair : net.pairs) {
    for (const Anchor& a : anchors[pair.i]) {
      for (const Anchor& b : anchors[pair.j]) {
        if (a.coarse == b.coarse) continue;
        coarse.pairs.push_back({std::min(a.coarse, b.coarse), std::max(a.coarse, b.coarse),
                                a.distance + pair.length + b.distance});
      }
    }
  }
  // The shortest way of each pair.
  const auto byPair = [](const Net::Pair& a, const Net::Pair& b) {
    return std::tie(a.i, a.j, a.length) < std::tie(b.i, b.j, b.length);
  };
  std::sort(coarse.pairs.begin(), coarse.pairs.end(), byPair);
  coarse.pairs.erase(
      std::unique(coarse.pairs.begin(), coarse.pairs.end(),
                  [](const Net::Pair& a, const Net::Pair& b) { return a.i == b.i && a.j == b.j; }),
      coarse.pairs.end());
  if (net.positions.cols() > 0) {
    coarse.positions.resize(3, coarse.size);
    for (std::uint32_t c = 0; c < coarse.size; ++c) {
      coarse.positions.col(c) = net.positions.col(chosen[c]);
    }
  }
  net = std::move(coarse);
  return result;
}

}  // namespace mass_spring
