#include "solvers/incomplete_cholesky.h"

#include <algorithm>

namespace mass_spring {

IncompleteCholesky::IncompleteCholesky(std::shared_ptr<const BlockPattern> pattern)
    : pattern_(std::move(pattern)),
      row_start_(pattern_->size() + 1, 0),
      column_(pattern_->blocks()),
      slot_(pattern_->blocks()),
      lower_(pattern_->blocks()),
      scaled_(pattern_->blocks()),
      inverse_pivot_(pattern_->size()) {
  const std::uint32_t n = pattern_->size();
  for (std::size_t s = 0; s < pattern_->blocks(); ++s) ++row_start_[pattern_->column(s) + 1];
  for (std::uint32_t i = 0; i < n; ++i) row_start_[i + 1] += row_start_[i];
  std::vector<std::uint32_t> next(row_start_.begin(), row_start_.end() - 1);
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::size_t s = pattern_->rowStart(j); s < pattern_->rowStart(j + 1); ++s) {
      const std::uint32_t entry = next[pattern_->column(s)]++;
      column_[entry] = j;
      slot_[entry] = static_cast<std::uint32_t>(s);
    }
  }
  update_start_.reserve(column_.size() + 1);
  for (std::uint32_t i = 0; i < n; ++i) {
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

bool IncompleteCholesky::factorize(const StepMatrix& matrix) {
  for (double shift : {0.0, 0.01, 0.1, 1.0, 10.0, 1e3, 1e6}) {
    if (factorize(matrix, shift)) return true;
  }
  std::fill(lower_.begin(), lower_.end(), Block3{});
  for (std::uint32_t i = 0; i < pattern_->size(); ++i) {
    if (!matrix.diagonal()[i].invert(inverse_pivot_[i])) return false;
  }
  return true;
}

bool IncompleteCholesky::factorize(const StepMatrix& matrix, double shift) {
  for (std::uint32_t i = 0; i < pattern_->size(); ++i) {
    SymmetricBlock pivot = matrix.diagonal()[i];
    if (shift > 0.0) {
      pivot += SymmetricBlock::isotropic(shift * (pivot.xx + pivot.yy + pivot.zz) / 3.0);
    }
    for (std::uint32_t ij = row_start_[i]; ij < row_start_[i + 1]; ++ij) {
      Block3 w = Block3::from(matrix.upper()[slot_[ij]]);
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

void IncompleteCholesky::apply(const Vectors& r, Vectors& z) const {
  const std::uint32_t n = pattern_->size();
  double* out = z.data();
  const double* in = r.data();
  for (std::uint32_t i = 0; i < n; ++i) {
    double y[3] = {in[3 * i], in[3 * i + 1], in[3 * i + 2]};
    for (std::uint32_t e = row_start_[i]; e < row_start_[i + 1]; ++e) {
      lower_[e].multiplySubtract(out + 3 * column_[e], y);
    }
    out[3 * i] = y[0], out[3 * i + 1] = y[1], out[3 * i + 2] = y[2];
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const double y[3] = {out[3 * i], out[3 * i + 1], out[3 * i + 2]};
    out[3 * i] = out[3 * i + 1] = out[3 * i + 2] = 0.0;
    inverse_pivot_[i].multiplyAdd(y, out + 3 * i);
  }
  for (std::uint32_t i = n; i-- > 0;) {
    const double* x = out + 3 * i;
    for (std::uint32_t e = row_start_[i]; e < row_start_[i + 1]; ++e) {
      lower_[e].multiplyTransposedSubtract(x, out + 3 * column_[e]);
    }
  }
}

}  // namespace mass_spring
