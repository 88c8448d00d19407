#pragma once

#include <cholmod.h>

#include <memory>

#include "solvers/direct_solver.h"

namespace mass_spring {

/// The supernodal factor of SuiteSparse's CHOLMOD, for large fill: dense panels and BLAS. Compiled
/// with MASS_SPRING_WITH_CHOLMOD only. (Chen, Davis, Hager and Rajamanickam, Algorithm 887, 2008.)
class CholmodCholesky : public DirectSolver {
 public:
  /// @param block_products  of a factor in order of minimum degree; CHOLMOD finds its own order
  /// when
  ///                        it is first needed, which takes as long as some factorizations
  CholmodCholesky(std::shared_ptr<const BlockPattern> pattern, double block_products);
  ~CholmodCholesky() override;
  CholmodCholesky(const CholmodCholesky&) = delete;
  CholmodCholesky& operator=(const CholmodCholesky&) = delete;

  double blockProducts() const override { return block_products_; }
  void reserve() override;
  bool factorize(const StepMatrix& matrix) override;
  void solve(const Vectors& b, Vectors& x) override;

 private:
  std::shared_ptr<const BlockPattern> pattern_;
  double block_products_;
  cholmod_common common_;
  cholmod_sparse* lower_ = nullptr;  // triangle of the matrix, scalars by columns
  cholmod_factor* factor_ = nullptr;
  cholmod_dense *solution_ = nullptr, *work_ = nullptr, *more_work_ = nullptr;
};

}  // namespace mass_spring
