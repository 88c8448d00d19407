#include "solvers/ordering.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <limits>

namespace mass_spring {
namespace {

/// Neighbors of each particle: [start[i], start[i + 1]) of `neighbor`.
struct Graph {
  std::vector<std::size_t> start;
  std::vector<std::uint32_t> neighbor;

  explicit Graph(const BlockPattern& pattern) : start(pattern.size() + 1, 0) {
    const auto forEachPair = [&](const auto& visit) {
      for (std::uint32_t i = 0; i < pattern.size(); ++i) {
        for (std::size_t s = pattern.rowStart(i); s < pattern.rowStart(i + 1); ++s) {
          visit(i, pattern.column(s));
          visit(pattern.column(s), i);
        }
      }
    };
    forEachPair([&](std::uint32_t i, std::uint32_t) { ++start[i + 1]; });
    for (std::uint32_t i = 0; i < pattern.size(); ++i) start[i + 1] += start[i];
    neighbor.resize(start.back());
    std::vector<std::size_t> next(start.begin(), start.end() - 1);
    forEachPair([&](std::uint32_t i, std::uint32_t j) { neighbor[next[i]++] = j; });
    // The order of Cuthill and McKee: those with few neighbors first.
    for (std::uint32_t i = 0; i < pattern.size(); ++i) {
      std::sort(neighbor.begin() + static_cast<std::ptrdiff_t>(start[i]),
                neighbor.begin() + static_cast<std::ptrdiff_t>(start[i + 1]),
                [this](std::uint32_t a, std::uint32_t b) {
                  return std::make_pair(degree(a), a) < std::make_pair(degree(b), b);
                });
    }
  }
  std::size_t degree(std::uint32_t i) const { return start[i + 1] - start[i]; }
};

/// Visits a component of the graph breadth first.
class BreadthFirst {
 public:
  explicit BreadthFirst(const Graph& graph) : graph_(graph), depth_(graph.start.size() - 1, kNew) {}

  bool reached(std::uint32_t i) const { return depth_[i] != kNew; }
  /// Appends the component of `root` to `order`. @return its depth
  std::uint32_t append(std::uint32_t root, std::vector<std::uint32_t>& order) {
    std::size_t head = order.size();
    order.push_back(root);
    depth_[root] = 0;
    for (; head < order.size(); ++head) {
      const std::uint32_t i = order[head];
      for (std::size_t e = graph_.start[i]; e < graph_.start[i + 1]; ++e) {
        const std::uint32_t j = graph_.neighbor[e];
        if (reached(j)) continue;
        depth_[j] = depth_[i] + 1;
        order.push_back(j);
      }
    }
    return depth_[order.back()];
  }
  /// Takes back what append() appended since the order had `size` entries.
  void forget(std::size_t size, std::vector<std::uint32_t>& order) {
    for (std::size_t k = size; k < order.size(); ++k) depth_[order[k]] = kNew;
    order.resize(size);
  }

 private:
  static constexpr std::uint32_t kNew = std::numeric_limits<std::uint32_t>::max();
  const Graph& graph_;
  std::vector<std::uint32_t> depth_;  // from the root
};

}  // namespace

std::vector<std::uint32_t> minimumDegreeOrder(const BlockPattern& pattern) {
  const auto n = static_cast<int>(pattern.size());
  std::vector<Eigen::Triplet<double, int>> entries;
  entries.reserve(2 * pattern.blocks() + pattern.size());
  for (int i = 0; i < n; ++i) {
    entries.emplace_back(i, i, 1.0);
    const auto row = static_cast<std::uint32_t>(i);
    for (std::size_t s = pattern.rowStart(row); s < pattern.rowStart(row + 1); ++s) {
      const auto j = static_cast<int>(pattern.column(s));
      entries.emplace_back(i, j, 1.0);
      entries.emplace_back(j, i, 1.0);
    }
  }
  Eigen::SparseMatrix<double> graph(n, n);
  graph.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
  Eigen::AMDOrdering<int>()(graph, permutation);
  std::vector<std::uint32_t> order(pattern.size());
  for (int i = 0; i < n; ++i) {
    order[static_cast<std::size_t>(i)] = static_cast<std::uint32_t>(permutation.indices()[i]);
  }
  return order;
}

std::vector<std::uint32_t> reverseCuthillMcKeeOrder(const BlockPattern& pattern) {
  const Graph graph(pattern);
  BreadthFirst search(graph);
  std::vector<std::uint32_t> order;
  order.reserve(pattern.size());
  for (std::uint32_t i = 0; i < pattern.size(); ++i) {
    if (search.reached(i)) continue;
    // The far end of a search is a better root, as long as that makes the search deeper.
    const std::size_t begin = order.size();
    std::uint32_t depth = search.append(i, order);
    for (;;) {
      const std::uint32_t end = order.back();
      search.forget(begin, order);
      const std::uint32_t deeper = search.append(end, order);
      if (deeper <= depth) break;
      depth = deeper;
    }
  }
  std::reverse(order.begin(), order.end());
  return order;
}

double bandProducts(const BlockPattern& pattern, const std::vector<std::uint32_t>& order) {
  std::vector<std::uint32_t> position(pattern.size()), first(pattern.size());
  for (std::uint32_t k = 0; k < pattern.size(); ++k) position[order[k]] = first[k] = k;
  for (std::uint32_t i = 0; i < pattern.size(); ++i) {
    for (std::size_t s = pattern.rowStart(i); s < pattern.rowStart(i + 1); ++s) {
      const std::uint32_t p = position[i], q = position[pattern.column(s)];
      first[std::max(p, q)] = std::min(first[std::max(p, q)], std::min(p, q));
    }
  }
  double products = 0.0;
  for (std::uint32_t k = 0; k < pattern.size(); ++k) {
    const double width = k - first[k];
    products += 0.5 * width * (width + 1.0);
  }
  return products;
}

}  // namespace mass_spring
