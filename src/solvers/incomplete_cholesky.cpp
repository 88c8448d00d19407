#include "solvers/incomplete_cholesky.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "solvers/dispatch.h"

namespace mass_spring {
namespace {

constexpr std::size_t kFill = std::numeric_limits<std::size_t>::max();

// A particle with more later neighbors than this, the hub of a star, would couple all of them with
// one another; its fill is left out. Cloth has 6, lattices up to 16.
constexpr std::size_t kMostFilled = 32;

}  // namespace

IncompleteCholesky::IncompleteCholesky(std::shared_ptr<const BlockPattern> pattern)
    : pattern_(std::move(pattern)), inverse_pivot_(pattern_->size()) {
  findEntries();
  findUpdates();
  findColumns();
  lower_.resize(column_.size());
  scaled_.resize(column_.size());
  forward_.resize(kBlock * column_.size() + 1);
  backward_.resize(kBlock * column_.size() + 1);
}

void IncompleteCholesky::findEntries() {
  const std::uint32_t n = pattern_->size();
  std::vector<std::vector<std::pair<std::uint32_t, std::size_t>>> rows(n);  // column, slot
  for (std::uint32_t k = 0; k < n; ++k) {
    const std::size_t end = pattern_->rowStart(k + 1);
    for (std::size_t s = pattern_->rowStart(k); s < end; ++s) {
      rows[pattern_->column(s)].emplace_back(k, s);
      // Eliminating k couples all its later neighbors.
      if (end - pattern_->rowStart(k) > kMostFilled) continue;
      for (std::size_t t = s + 1; t < end; ++t) {
        rows[pattern_->column(t)].emplace_back(pattern_->column(s), kFill);
      }
    }
  }
  row_start_.push_back(0);
  for (auto& row : rows) {
    std::sort(row.begin(), row.end());  // of equal columns, the block of A comes first
    for (const auto& [column, slot] : row) {
      if (column_.size() > row_start_.back() && column_.back() == column) continue;
      column_.push_back(column);
      slot_.push_back(slot);
    }
    row_start_.push_back(static_cast<std::uint32_t>(column_.size()));
  }
}

void IncompleteCholesky::findUpdates() {
  for (std::uint32_t i = 0; i < pattern_->size(); ++i) {
    for (std::uint32_t ij = row_start_[i]; ij < row_start_[i + 1]; ++ij) {
      update_start_.push_back(static_cast<std::uint32_t>(updates_.size()));
      const std::uint32_t j = column_[ij];
      std::uint32_t ik = row_start_[i];
      for (std::uint32_t jk = row_start_[j]; jk < row_start_[j + 1] && ik < ij; ++jk) {
        while (ik < ij && column_[ik] < column_[jk]) ++ik;
        if (ik < ij && column_[ik] == column_[jk]) updates_.push_back({ik, jk});
      }
    }
  }
  update_start_.push_back(static_cast<std::uint32_t>(updates_.size()));
}

void IncompleteCholesky::findColumns() {
  const std::uint32_t n = pattern_->size();
  column_start_.assign(n + 1, 0);
  for (const std::uint32_t column : column_) ++column_start_[column + 1];
  for (std::uint32_t j = 0; j < n; ++j) column_start_[j + 1] += column_start_[j];
  row_.resize(column_.size());
  entry_.resize(column_.size());
  std::vector<std::uint32_t> next(column_start_.begin(), column_start_.end() - 1);
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t e = row_start_[i]; e < row_start_[i + 1]; ++e) {
      const std::uint32_t place = next[column_[e]]++;
      row_[place] = i;
      entry_[place] = e;
    }
  }
}

bool IncompleteCholesky::prepare(const StepMatrix& matrix) {
  bool done = false;
  for (double shift : {0.0, 0.01, 0.1, 1.0, 10.0, 1e3, 1e6}) {
    done = factorize(matrix, shift);
    if (done) break;
  }
  if (!done) {
    std::fill(lower_.begin(), lower_.end(), Block3{});
    for (std::uint32_t i = 0; i < pattern_->size(); ++i) {
      if (!matrix.diagonal()[i].invert(inverse_pivot_[i])) return false;
    }
  }
  for (std::size_t e = 0; e < lower_.size(); ++e) {
    float* const by_columns = &forward_[kBlock * e];
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c)
        by_columns[3 * c + r] = static_cast<float>(lower_[e].a[3 * r + c]);
    }
  }
  for (std::size_t u = 0; u < lower_.size(); ++u) {
    float* const by_rows = &backward_[kBlock * u];
    for (int k = 0; k < 9; ++k) by_rows[k] = static_cast<float>(lower_[entry_[u]].a[k]);
  }
  return true;
}

MASS_SPRING_DISPATCH
bool IncompleteCholesky::factorize(const StepMatrix& matrix, double shift) {
  for (std::uint32_t i = 0; i < pattern_->size(); ++i) {
    SymmetricBlock pivot = matrix.diagonal()[i];
    if (shift > 0.0) {
      pivot += SymmetricBlock::isotropic(shift * (pivot.xx + pivot.yy + pivot.zz) / 3.0);
    }
    for (std::uint32_t ij = row_start_[i]; ij < row_start_[i + 1]; ++ij) {
      Block3 w = slot_[ij] == kFill ? Block3{} : Block3::from(matrix.upper()[slot_[ij]]);
      for (std::uint32_t u = update_start_[ij]; u < update_start_[ij + 1]; ++u) {
        w.subtractProductTransposed(scaled_[updates_[u].ik], lower_[updates_[u].jk]);
      }
      scaled_[ij] = w;
      lower_[ij] = w.times(inverse_pivot_[column_[ij]]);
      w.subtractSymmetricProduct(lower_[ij], pivot);
    }
    if (!pivot.invert(inverse_pivot_[i])) return false;
  }
  return true;
}

void IncompleteCholesky::apply(const FloatVectors& r, FloatVectors& z, FloatVectors&) {
  substitute(r, z);
}

MASS_SPRING_DISPATCH
void IncompleteCholesky::substitute(const FloatVectors& r, FloatVectors& z) const {
  const std::uint32_t n = pattern_->size();
  for (std::uint32_t i = 0; i < n; ++i) {
    Eigen::Array4f y = r.col(i);
    for (std::uint32_t e = row_start_[i]; e < row_start_[i + 1]; ++e) {
      multiplySubtract(&forward_[kBlock * e], &z(0, column_[e]), y);
    }
    z.col(i) = y;
  }
  for (std::uint32_t i = n; i-- > 0;) {
    const double y[3] = {z(0, i), z(1, i), z(2, i)};
    double v[3] = {0.0, 0.0, 0.0};
    inverse_pivot_[i].multiplyAdd(y, v);
    Eigen::Array4f x(static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]),
                     0.0f);
    // The nearest last: it is the latest to be known.
    for (std::uint32_t u = column_start_[i + 1]; u-- > column_start_[i];) {
      multiplySubtract(&backward_[kBlock * u], &z(0, row_[u]), x);
    }
    z.col(i) = x;
  }
}

}  // namespace mass_spring
