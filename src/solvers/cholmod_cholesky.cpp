#include "solvers/cholmod_cholesky.h"

#include <new>

namespace mass_spring {
namespace {

/// Nine scalars of a symmetric block, or six of its lower triangle, appended to three columns.
void append(const SymmetricBlock& s, bool whole, double*& x, double*& y, double*& z) {
  *x++ = s.xx, *x++ = s.xy, *x++ = s.xz;
  if (whole) *y++ = s.xy;
  *y++ = s.yy, *y++ = s.yz;
  if (whole) *z++ = s.xz, *z++ = s.yz;
  *z++ = s.zz;
}

}  // namespace

CholmodCholesky::CholmodCholesky(std::shared_ptr<const BlockPattern> pattern, double block_products)
    : pattern_(std::move(pattern)), block_products_(block_products) {
  cholmod_start(&common_);
  common_.print = 0;
  common_.supernodal = CHOLMOD_SUPERNODAL;
  common_.quick_return_if_not_posdef = 1;
}

void CholmodCholesky::reserve() {
  const std::uint32_t n = pattern_->size();
  // Row i of the upper triangle of blocks is column i of the lower one.
  lower_ = cholmod_allocate_sparse(3 * n, 3 * n, 6 * n + 9 * pattern_->blocks(), 1, 1, -1,
                                   CHOLMOD_REAL, &common_);
  if (!lower_) throw std::bad_alloc();
  int* const start = static_cast<int*>(lower_->p);
  int* const row = static_cast<int*>(lower_->i);
  int entry = 0;
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      start[3 * i + c] = entry;
      for (std::uint32_t r = c; r < 3; ++r) row[entry++] = static_cast<int>(3 * i + r);
      for (std::size_t s = pattern_->rowStart(i); s < pattern_->rowStart(i + 1); ++s) {
        for (std::uint32_t r = 0; r < 3; ++r) {
          row[entry++] = static_cast<int>(3 * pattern_->column(s) + r);
        }
      }
    }
  }
  start[3 * n] = entry;
  factor_ = cholmod_analyze(lower_, &common_);
  if (!factor_) throw std::bad_alloc();
}

CholmodCholesky::~CholmodCholesky() {
  cholmod_free_dense(&more_work_, &common_);
  cholmod_free_dense(&work_, &common_);
  cholmod_free_dense(&solution_, &common_);
  cholmod_free_factor(&factor_, &common_);
  cholmod_free_sparse(&lower_, &common_);
  cholmod_finish(&common_);
}

bool CholmodCholesky::factorize(const StepMatrix& matrix) {
  if (!factor_) reserve();
  const int* const start = static_cast<const int*>(lower_->p);
  double* const values = static_cast<double*>(lower_->x);
  for (std::uint32_t i = 0; i < pattern_->size(); ++i) {
    double *x = values + start[3 * i], *y = values + start[3 * i + 1],
           *z = values + start[3 * i + 2];
    append(matrix.diagonal()[i], false, x, y, z);
    for (std::size_t s = pattern_->rowStart(i); s < pattern_->rowStart(i + 1); ++s) {
      append(matrix.upper()[s], true, x, y, z);
    }
  }
  return cholmod_factorize(lower_, factor_, &common_) && common_.status == CHOLMOD_OK &&
         factor_->minor == factor_->n;
}

void CholmodCholesky::solve(const Vectors& b, Vectors& x) {
  const auto n = static_cast<std::size_t>(b.size());
  cholmod_dense right_side{};
  right_side.nrow = right_side.nzmax = right_side.d = n;
  right_side.ncol = 1;
  right_side.x = const_cast<double*>(b.data());  // read only
  right_side.xtype = CHOLMOD_REAL;
  right_side.dtype = CHOLMOD_DOUBLE;
  cholmod_solve2(CHOLMOD_A, factor_, &right_side, nullptr, &solution_, nullptr, &work_, &more_work_,
                 &common_);
  x = Eigen::Map<const Vectors>(static_cast<const double*>(solution_->x), 3, b.cols());
}

}  // namespace mass_spring
