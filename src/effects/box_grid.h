#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace mass_spring {

/// Along the axes; empty if low > high.
struct Box3 {
  Eigen::Array3d low, high;  ///< m
  bool meets(const Box3& other) const {
    return (low <= other.high).all() && (other.low <= high).all();
  }
};

/// Finds boxes by a uniform grid, whose cells are about as large as the boxes; those that reach
/// over very many cells are kept aside.
class BoxGrid {
 public:
  void fill(const std::vector<Box3>& boxes);
  /// The numbers of the boxes of fill() that meet this one, ascending.
  void find(const Box3& box, std::vector<std::uint32_t>& found) const;

 private:
  struct Cells {
    Eigen::Array3i low, high;
    double count() const;
  };
  Cells cells(const Box3& box) const;
  /// visit(bucket) of each cell; different cells may share one.
  template <typename Visit>
  void forEachBucket(const Cells& cells, Visit visit) const;

  const std::vector<Box3>* boxes_ = nullptr;
  double cell_ = 1.0;  // m
  std::uint32_t mask_ = 0;
  std::vector<std::uint32_t> start_, entries_, large_;
};

}  // namespace mass_spring
