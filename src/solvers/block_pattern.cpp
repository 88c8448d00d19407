#include "solvers/block_pattern.h"

#include <algorithm>

namespace mass_spring {

void PatternBuilder::couple(std::uint32_t i, std::uint32_t j) {
  pairs_.emplace_back(std::min(i, j), std::max(i, j));
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> PatternBuilder::sortedPairs() && {
  std::sort(pairs_.begin(), pairs_.end());
  pairs_.erase(std::unique(pairs_.begin(), pairs_.end()), pairs_.end());
  return std::move(pairs_);
}

BlockPattern::BlockPattern(std::uint32_t size, PatternBuilder builder) : row_start_(size + 1, 0) {
  const auto pairs = std::move(builder).sortedPairs();
  column_.reserve(pairs.size());
  for (const auto& [row, column] : pairs) {
    ++row_start_[row + 1];
    column_.push_back(column);
  }
  for (std::uint32_t i = 0; i < size; ++i) row_start_[i + 1] += row_start_[i];
}

std::size_t BlockPattern::slot(std::uint32_t i, std::uint32_t j) const {
  const auto begin = column_.begin() + static_cast<std::ptrdiff_t>(row_start_[std::min(i, j)]);
  const auto end = column_.begin() + static_cast<std::ptrdiff_t>(row_start_[std::min(i, j) + 1]);
  return static_cast<std::size_t>(std::lower_bound(begin, end, std::max(i, j)) - column_.begin());
}

}  // namespace mass_spring
