#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace mass_spring {

/// Along the axes [m]; empty if low > high.
struct AlignedBox {
  std::array<double, 3> low, high;
  static AlignedBox empty();
  void include(const AlignedBox& other);
  bool meets(const AlignedBox& other) const {
    return low[0] <= other.high[0] && other.low[0] <= high[0] && low[1] <= other.high[1] &&
           other.low[1] <= high[1] && low[2] <= other.high[2] && other.low[2] <= high[2];
  }
};

/// Finds boxes by a tree of the boxes around them. The tree is made once, for where things are at
/// rest; neighbors stay neighbors in cloth, so that it serves also when they have moved.
class BoxTree {
 public:
  /// @param centers  of the boxes at rest, a column each
  explicit BoxTree(const Eigen::Matrix3Xd& centers);

  /// Takes the boxes as they are now, as many as there were centers.
  void fit(const std::vector<AlignedBox>& boxes);
  /// The numbers of the boxes that meet this one, ascending.
  void find(const AlignedBox& box, std::vector<std::uint32_t>& found) const;

 private:
  /// In the order of a walk that goes down first.
  struct Node {
    AlignedBox box;
    std::uint32_t begin, end;  ///< of order_
    std::uint32_t next;        ///< the first node that is not below this one
    bool leaf;
  };
  void divide(const Eigen::Matrix3Xd& centers, std::uint32_t begin, std::uint32_t end);

  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
  std::vector<AlignedBox> boxes_;  // in that order
};

}  // namespace mass_spring
