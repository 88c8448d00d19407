#include "solvers/step_matrix.h"

#include <algorithm>

#include "solvers/dispatch.h"

namespace mass_spring {

StepMatrix::StepMatrix(std::shared_ptr<const BlockPattern> pattern, ThreadPool* threads)
    : pattern_(std::move(pattern)),
      threads_(threads),
      diagonal_(pattern_->size()),
      upper_(pattern_->blocks()),
      weighted_masses_(pattern_->size()) {}

void StepMatrix::setMasses(double weight, const Eigen::VectorXd& masses) {
  weighted_masses_ = weight * masses;
  ties_.clear();
  inHalves([&](std::uint32_t, std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t i = begin; i < end; ++i) {
      diagonal_[i] = SymmetricBlock::isotropic(weighted_masses_[i]);
    }
    const auto blocks = [&](std::uint32_t i) {
      return upper_.begin() + static_cast<std::ptrdiff_t>(pattern_->rowStart(i));
    };
    std::fill(blocks(begin), blocks(end), SymmetricBlock{});
  });
}

void StepMatrix::multiply(const Vectors& x, Vectors& y) const {
  const double* const in = x.data();
  double* const out = y.data();
  inHalves([&](std::uint32_t, std::uint32_t begin, std::uint32_t end) {
    multiplyRows(begin, end, in, out);
  });
  addCoupling(in, out);
  addTies(1.0, x, y);
}

MASS_SPRING_DISPATCH
void StepMatrix::multiplyRows(std::uint32_t begin, std::uint32_t end, const double* in,
                              double* out) const {
  const RowHalves& halves = pattern_->halves();
  for (std::uint32_t i = begin; i < end; ++i) {
    const SymmetricBlock& d = diagonal_[i];
    const double* u = in + 3 * i;
    out[3 * i + 0] = d.xx * u[0] + d.xy * u[1] + d.xz * u[2];
    out[3 * i + 1] = d.xy * u[0] + d.yy * u[1] + d.yz * u[2];
    out[3 * i + 2] = d.xz * u[0] + d.yz * u[1] + d.zz * u[2];
  }
  // Each stored block serves its row and, transposed (it is symmetric), its column.
  const std::uint32_t* const column = pattern_->rows().column.data();
  for (std::uint32_t i = begin; i < end; ++i) {
    const double* u = in + 3 * i;
    const double ux = u[0], uy = u[1], uz = u[2];
    double sx = 0.0, sy = 0.0, sz = 0.0;
    const std::uint32_t row_end = halves.rowEnd(i);
    for (std::uint32_t s = pattern_->rows().start[i]; s < row_end; ++s) {
      const SymmetricBlock& b = upper_[s];
      const double* v = in + 3 * column[s];
      double* w = out + 3 * column[s];
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

void StepMatrix::addCoupling(const double* in, double* out) const {
  const RowHalves& halves = pattern_->halves();
  for (std::uint32_t i = halves.firstCoupled(); i < halves.lastCoupled(); ++i) {
    for (std::size_t s = halves.rowEnd(i); s < pattern_->rowStart(i + 1); ++s) {
      const std::uint32_t j = pattern_->column(s);
      upper_[s].multiplyAdd(in + 3 * j, out + 3 * i);
      upper_[s].multiplyAdd(in + 3 * i, out + 3 * j);
    }
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
  for (Tie& tie : ties_) {
    for (int a = 0; a < 4; ++a) {
      if (pinned[tie.particles[static_cast<std::size_t>(a)]]) tie.weights[a] = 0.0;
    }
  }
}

}  // namespace mass_spring
