#include "solvers/row_halves.h"

#include <algorithm>

namespace mass_spring {
namespace {

// Below this many particles a second thread costs more than it saves.
constexpr std::uint32_t kLeastToSplit = 512;

}  // namespace

RowHalves::RowHalves(const BlockRows& rows)
    : size_(rows.size()),
      parts_(size_ < kLeastToSplit ? 1 : 2),
      split_(0),
      first_coupled_(0),
      row_end_(rows.start.begin() + 1, rows.start.end()) {
  if (parts_ == 1) return;
  const std::size_t work = size_ + rows.column.size();
  while (2 * (split_ + rows.start[split_]) < work) ++split_;
  first_coupled_ = split_;
  for (std::uint32_t i = split_; i-- > 0;) {
    const auto first = rows.column.begin() + rows.start[i];
    const auto last = rows.column.begin() + rows.start[i + 1];
    row_end_[i] =
        static_cast<std::uint32_t>(std::lower_bound(first, last, split_) - rows.column.begin());
    if (row_end_[i] < rows.start[i + 1]) first_coupled_ = i;
  }
}

}  // namespace mass_spring
