#include "solvers/sparse_cholesky.h"

#include <algorithm>
#include <limits>

#include "solvers/dispatch.h"

namespace mass_spring {
namespace {

constexpr std::uint32_t kNever = std::numeric_limits<std::uint32_t>::max();

}  // namespace

SparseCholesky::SparseCholesky(std::shared_ptr<const BlockPattern> pattern,
                               std::vector<std::uint32_t> order)
    : pattern_(std::move(pattern)),
      order_(std::move(order)),
      position_(pattern_->size()),
      a_start_(pattern_->size() + 1, 0),
      a_row_(pattern_->blocks()),
      a_slot_(pattern_->blocks()),
      parent_(pattern_->size(), -1),
      l_start_(pattern_->size() + 1, 0),
      mark_(pattern_->size(), kNever) {
  const std::uint32_t n = pattern_->size();
  for (std::uint32_t k = 0; k < n; ++k) position_[order_[k]] = k;

  const auto forEachBlock = [&](const auto& visit) {
    for (std::uint32_t i = 0; i < n; ++i) {
      for (std::size_t s = pattern_->rowStart(i); s < pattern_->rowStart(i + 1); ++s) {
        const std::uint32_t p = position_[i], q = position_[pattern_->column(s)];
        visit(std::min(p, q), std::max(p, q), s);
      }
    }
  };
  forEachBlock([&](std::uint32_t, std::uint32_t column, std::size_t) { ++a_start_[column + 1]; });
  for (std::uint32_t k = 0; k < n; ++k) a_start_[k + 1] += a_start_[k];
  std::vector<std::size_t> next(a_start_.begin(), a_start_.end() - 1);
  forEachBlock([&](std::uint32_t row, std::uint32_t column, std::size_t slot) {
    a_row_[next[column]] = row;
    a_slot_[next[column]++] = slot;
  });

  // Elimination tree and column counts: row k of L reaches every ancestor (below k) of the entries
  // of row k of A (Davis, Direct Methods for Sparse Linear Systems, 2006, ch. 4).
  std::vector<std::size_t> count(n, 0);
  for (std::uint32_t k = 0; k < n; ++k) {
    mark_[k] = k;
    for (std::size_t e = a_start_[k]; e < a_start_[k + 1]; ++e) {
      for (std::uint32_t j = a_row_[e]; mark_[j] != k;) {
        mark_[j] = k;
        // Column j holds count[j] entries above row k, each of which this row updates.
        block_products_ += static_cast<double>(count[j] + 1);
        ++count[j];
        if (parent_[j] < 0) parent_[j] = k;
        j = static_cast<std::uint32_t>(parent_[j]);
      }
    }
  }
  for (std::uint32_t k = 0; k < n; ++k) l_start_[k + 1] = l_start_[k] + count[k];
}

void SparseCholesky::reserve() {
  const std::uint32_t n = pattern_->size();
  l_row_.resize(l_start_[n]);
  l_.resize(l_start_[n]);
  pivot_.resize(n);
  l_end_.resize(n);
  work_.assign(n, Block3{});
  reach_.resize(n);
  path_.resize(n);
  permuted_.resize(3, n);
}

bool SparseCholesky::factorize(const StepMatrix& matrix) {
  if (pivot_.size() != pattern_->size()) reserve();
  return eliminate(matrix);
}

void SparseCholesky::solve(const Vectors& b, Vectors& x) { substitute(b, x); }

MASS_SPRING_DISPATCH
bool SparseCholesky::eliminate(const StepMatrix& matrix) {
  const std::uint32_t n = pattern_->size();
  std::fill(mark_.begin(), mark_.end(), kNever);
  for (std::uint32_t k = 0; k < n; ++k) {
    // Row k of the matrix, scattered; and the columns it reaches, so that each comes before those
    // it updates.
    std::uint32_t top = n;
    mark_[k] = k;
    for (std::size_t e = a_start_[k]; e < a_start_[k + 1]; ++e) {
      work_[a_row_[e]] = Block3::from(matrix.upper()[a_slot_[e]]);
      std::uint32_t length = 0;
      for (std::uint32_t j = a_row_[e]; mark_[j] != k;) {
        path_[length++] = j;
        mark_[j] = k;
        j = static_cast<std::uint32_t>(parent_[j]);
      }
      while (length > 0) reach_[--top] = path_[--length];
    }
    SymmetricBlock pivot = matrix.diagonal()[order_[k]];
    for (std::uint32_t t = top; t < n; ++t) {
      const std::uint32_t j = reach_[t];
      Block3 l = work_[j];
      work_[j] = Block3{};
      for (int row = 0; row < 3; ++row) pivot_[j].solve(l.a + 3 * row);
      for (std::size_t e = l_start_[j]; e < l_end_[j]; ++e) {
        work_[l_row_[e]].subtractProductTransposed(l, l_[e]);
      }
      l.subtractSymmetricProduct(l, pivot);
      l_row_[l_end_[j]] = k;
      l_[l_end_[j]++] = l;
    }
    l_end_[k] = l_start_[k];
    if (!pivot_[k].factorize(pivot)) {
      std::fill(work_.begin(), work_.end(), Block3{});
      return false;
    }
  }
  return true;
}

MASS_SPRING_DISPATCH
void SparseCholesky::substitute(const Vectors& b, Vectors& x) {
  const std::uint32_t n = pattern_->size();
  double* y = permuted_.data();
  for (std::uint32_t k = 0; k < n; ++k) permuted_.col(k) = b.col(order_[k]);
  for (std::uint32_t j = 0; j < n; ++j) {
    pivot_[j].solve(y + 3 * j);
    for (std::size_t e = l_start_[j]; e < l_start_[j + 1]; ++e) {
      l_[e].multiplySubtract(y + 3 * j, y + 3 * l_row_[e]);
    }
  }
  for (std::uint32_t j = n; j-- > 0;) {
    for (std::size_t e = l_start_[j]; e < l_start_[j + 1]; ++e) {
      l_[e].multiplyTransposedSubtract(y + 3 * l_row_[e], y + 3 * j);
    }
    pivot_[j].solveTransposed(y + 3 * j);
  }
  for (std::uint32_t k = 0; k < n; ++k) x.col(order_[k]) = permuted_.col(k);
}

}  // namespace mass_spring
