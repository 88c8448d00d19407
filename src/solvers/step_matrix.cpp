#include "solvers/step_matrix.h"

#include <algorithm>

#include "solvers/dispatch.h"

namespace mass_spring {

StepMatrix::StepMatrix(std::shared_ptr<const BlockPattern> pattern)
    : pattern_(std::move(pattern)),
      diagonal_(pattern_->size()),
      upper_(pattern_->blocks()),
      weighted_masses_(pattern_->size()) {}

void StepMatrix::setMasses(double weight, const Eigen::VectorXd& masses) {
  weighted_masses_ = weight * masses;
  for (std::uint32_t i = 0; i < pattern_->size(); ++i) {
    diagonal_[i] = SymmetricBlock::isotropic(weighted_masses_[i]);
  }
  std::fill(upper_.begin(), upper_.end(), SymmetricBlock{});
}

MASS_SPRING_DISPATCH
void StepMatrix::multiply(const Vectors& x, Vectors& y) const {
  const std::uint32_t n = pattern_->size();
  const double* in = x.data();
  double* out = y.data();
  for (std::uint32_t i = 0; i < n; ++i) {
    const SymmetricBlock& d = diagonal_[i];
    const double* u = in + 3 * i;
    out[3 * i + 0] = d.xx * u[0] + d.xy * u[1] + d.xz * u[2];
    out[3 * i + 1] = d.xy * u[0] + d.yy * u[1] + d.yz * u[2];
    out[3 * i + 2] = d.xz * u[0] + d.yz * u[1] + d.zz * u[2];
  }
  // Each stored block serves its row and, transposed (it is symmetric), its column.
  for (std::uint32_t i = 0; i < n; ++i) {
    const double* u = in + 3 * i;
    const double ux = u[0], uy = u[1], uz = u[2];
    double sx = 0.0, sy = 0.0, sz = 0.0;
    for (std::size_t s = pattern_->rowStart(i); s < pattern_->rowStart(i + 1); ++s) {
      const SymmetricBlock& b = upper_[s];
      const double* v = in + 3 * pattern_->column(s);
      double* w = out + 3 * pattern_->column(s);
      sx += b.xx * v[0] + b.xy * v[1] + b.xz * v[2];
      sy += b.xy * v[0] + b.yy * v[1] + b.yz * v[2];
      sz += b.xz * v[0] + b.yz * v[1] + b.zz * v[2];
      w[0] += b.xx * ux + b.xy * uy + b.xz * uz;
      w[1] += b.xy * ux + b.yy * uy + b.yz * uz;
      w[2] += b.xz * ux + b.yz * uy + b.zz * uz;
    }
    out[3 * i + 0] += sx;
    out[3 * i + 1] += sy;
    out[3 * i + 2] += sz;
  }
}

void StepMatrix::shift(double share) {
  double largest = 0.0;
  for (const SymmetricBlock& d : diagonal_) largest = std::max({largest, d.xx, d.yy, d.zz});
  for (SymmetricBlock& d : diagonal_) d += SymmetricBlock::isotropic(share * largest);
}

void StepMatrix::decouple(const std::vector<char>& pinned) {
  for (std::uint32_t i = 0; i < pattern_->size(); ++i) {
    for (std::size_t s = pattern_->rowStart(i); s < pattern_->rowStart(i + 1); ++s) {
      if (pinned[i] || pinned[pattern_->column(s)]) upper_[s] = SymmetricBlock{};
    }
  }
}

}  // namespace mass_spring
