#include "effects/box_tree.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace mass_spring {
namespace {

constexpr std::uint32_t kLeaf = 4;  // boxes

}  // namespace

AlignedBox AlignedBox::empty() {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  return {{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}};
}

void AlignedBox::include(const AlignedBox& other) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    low[axis] = std::min(low[axis], other.low[axis]);
    high[axis] = std::max(high[axis], other.high[axis]);
  }
}

BoxTree::BoxTree(const Eigen::Matrix3Xd& centers)
    : order_(static_cast<std::size_t>(centers.cols())), boxes_(order_.size()) {
  std::iota(order_.begin(), order_.end(), 0u);
  if (!order_.empty()) divide(centers, 0, static_cast<std::uint32_t>(order_.size()));
}

void BoxTree::divide(const Eigen::Matrix3Xd& centers, std::uint32_t begin, std::uint32_t end) {
  const std::size_t node = nodes_.size();
  nodes_.push_back({AlignedBox::empty(), begin, end, 0, end - begin <= kLeaf});
  if (!nodes_[node].leaf) {
    Eigen::Vector3d low = centers.col(order_[begin]), high = low;
    for (std::uint32_t b = begin; b < end; ++b) {
      low = low.cwiseMin(centers.col(order_[b]));
      high = high.cwiseMax(centers.col(order_[b]));
    }
    Eigen::Index axis;
    (high - low).maxCoeff(&axis);
    const std::uint32_t middle = begin + (end - begin) / 2;
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                     [&](std::uint32_t a, std::uint32_t b) {
                       const double at_a = centers(axis, a), at_b = centers(axis, b);
                       return at_a < at_b || (at_a == at_b && a < b);
                     });
    divide(centers, begin, middle);
    divide(centers, middle, end);
  }
  nodes_[node].next = static_cast<std::uint32_t>(nodes_.size());
}

void BoxTree::fit(const std::vector<AlignedBox>& boxes) {
  for (std::size_t b = 0; b < order_.size(); ++b) boxes_[b] = boxes[order_[b]];
  for (std::size_t n = nodes_.size(); n-- > 0;) {
    Node& node = nodes_[n];
    node.box = AlignedBox::empty();
    if (node.leaf) {
      for (std::uint32_t b = node.begin; b < node.end; ++b) node.box.include(boxes_[b]);
    } else {
      const Node& first = nodes_[n + 1];
      node.box.include(first.box);
      node.box.include(nodes_[first.next].box);
    }
  }
}

void BoxTree::find(const AlignedBox& box, std::vector<std::uint32_t>& found) const {
  found.clear();
  for (std::size_t n = 0; n < nodes_.size();) {
    const Node& node = nodes_[n];
    if (!node.box.meets(box)) {
      n = node.next;
      continue;
    }
    if (node.leaf) {
      for (std::uint32_t b = node.begin; b < node.end; ++b) {
        if (boxes_[b].meets(box)) found.push_back(order_[b]);
      }
    }
    ++n;
  }
  std::sort(found.begin(), found.end());
}

}  // namespace mass_spring
