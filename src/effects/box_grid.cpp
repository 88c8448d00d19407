#include "effects/box_grid.h"

#include <algorithm>
#include <cmath>

namespace mass_spring {
namespace {

constexpr double kMostCells = 512.0;   // of a box that is not kept aside
constexpr double kLargestCell = 1e6;   // coordinate: further away all fall into the same cells
constexpr double kFinestGrid = 1e-12;  // of the largest coordinate

}  // namespace

double BoxGrid::Cells::count() const { return (high - low + 1).cast<double>().prod(); }

BoxGrid::Cells BoxGrid::cells(const Box3& box) const {
  const auto at = [&](const Eigen::Array3d& corner) {
    // A corner that is not a number falls on one end.
    return Eigen::Array3i((corner / cell_)
                              .floor()
                              .unaryExpr([](double c) {
                                return c > -kLargestCell ? (c < kLargestCell ? c : kLargestCell)
                                                         : -kLargestCell;
                              })
                              .cast<int>());
  };
  return {at(box.low), at(box.high)};
}

template <typename Visit>
void BoxGrid::forEachBucket(const Cells& cells, Visit visit) const {
  for (int z = cells.low[2]; z <= cells.high[2]; ++z) {
    for (int y = cells.low[1]; y <= cells.high[1]; ++y) {
      for (int x = cells.low[0]; x <= cells.high[0]; ++x) {
        // Large primes (Teschner et al., "Optimized spatial hashing", 2003).
        const std::uint32_t hash = static_cast<std::uint32_t>(x) * 73856093u ^
                                   static_cast<std::uint32_t>(y) * 19349663u ^
                                   static_cast<std::uint32_t>(z) * 83492791u;
        visit((hash ^ hash >> 15) & mask_);
      }
    }
  }
}

void BoxGrid::fill(const std::vector<Box3>& boxes) {
  boxes_ = &boxes;
  double sum = 0.0, furthest = 0.0;
  for (const Box3& box : boxes) {
    sum += (box.high - box.low).maxCoeff();
    furthest = std::max({furthest, box.low.abs().maxCoeff(), box.high.abs().maxCoeff()});
  }
  cell_ = std::max(sum / static_cast<double>(std::max<std::size_t>(boxes.size(), 1)),
                   kFinestGrid * furthest);
  if (!(cell_ > 0.0 && std::isfinite(cell_))) cell_ = 1.0;
  std::uint32_t buckets = 64;
  while (buckets < 2 * boxes.size()) buckets *= 2;
  mask_ = buckets - 1;
  start_.assign(buckets + 1, 0);
  large_.clear();
  for (std::uint32_t b = 0; b < boxes.size(); ++b) {
    const Cells reached = cells(boxes[b]);
    if (reached.count() > kMostCells) {
      large_.push_back(b);
    } else {
      forEachBucket(reached, [&](std::uint32_t bucket) { ++start_[bucket]; });
    }
  }
  // The ends of the buckets, which turn into their starts as these are filled from behind.
  for (std::uint32_t bucket = 0; bucket < buckets; ++bucket) start_[bucket + 1] += start_[bucket];
  entries_.resize(start_.back());
  for (auto b = static_cast<std::uint32_t>(boxes.size()); b-- > 0;) {
    const Cells reached = cells(boxes[b]);
    if (reached.count() > kMostCells) continue;
    forEachBucket(reached, [&](std::uint32_t bucket) { entries_[--start_[bucket]] = b; });
  }
}

void BoxGrid::find(const Box3& box, std::vector<std::uint32_t>& found) const {
  found.clear();
  const auto take = [&](std::uint32_t b) {
    if ((*boxes_)[b].meets(box)) found.push_back(b);
  };
  const Cells reached = cells(box);
  if (reached.count() > kMostCells) {
    for (std::uint32_t b = 0; b < boxes_->size(); ++b) take(b);
    return;
  }
  std::for_each(large_.begin(), large_.end(), take);
  forEachBucket(reached, [&](std::uint32_t bucket) {
    for (std::uint32_t e = start_[bucket]; e < start_[bucket + 1]; ++e) take(entries_[e]);
  });
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
}

}  // namespace mass_spring
