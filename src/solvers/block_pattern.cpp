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

namespace {

BlockRows rowsOf(std::uint32_t size, PatternBuilder builder) {
  const auto pairs = std::move(builder).sortedPairs();
  BlockRows rows;
  rows.start.assign(size + 1, 0);
  rows.column.reserve(pairs.size());
  for (const auto& [row, column] : pairs) {
    ++rows.start[row + 1];
    rows.column.push_back(column);
  }
  for (std::uint32_t i = 0; i < size; ++i) rows.start[i + 1] += rows.start[i];
  return rows;
}

}  // namespace

BlockPattern::BlockPattern(std::uint32_t size, PatternBuilder builder)
    : rows_(rowsOf(size, std::move(builder))), halves_(rows_) {}

std::size_t BlockPattern::slot(std::uint32_t i, std::uint32_t j) const {
  const std::uint32_t row = std::min(i, j);
  const auto begin = rows_.column.begin() + rows_.start[row];
  const auto end = rows_.column.begin() + rows_.start[row + 1];
  return static_cast<std::size_t>(std::lower_bound(begin, end, std::max(i, j)) -
                                  rows_.column.begin());
}

}  // namespace mass_spring
