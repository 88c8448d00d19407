#pragma once

#include <deque>
#include <memory>
#include <optional>

#include "mass_spring_sim/model.h"
#include "solvers/block_sweep.h"
#include "solvers/dense_cholesky.h"
#include "solvers/preconditioner.h"
#include "solvers/rest_shape.h"

namespace mass_spring {

/// One V-cycle of multigrid as a preconditioner: on every level a sweep of block Gauss-Seidel, the
/// correction by the next coarser level, and the sweep backwards, which makes the whole symmetric.
/// (Tamstorf, Jones, McCormick 2015 use smoothed aggregation for cloth; particles that know their
/// places at rest can have linear interpolation, which costs less per cycle.)
class Multigrid : public Preconditioner {
 public:
  Multigrid(const Model& model, ThreadPool& threads);

  bool prepare(const StepMatrix& matrix) override;
  void apply(const FloatVectors& r, FloatVectors& z, FloatVectors& work) override;
  bool multiplies() const override { return true; }
  double multiply(const FloatVectors& p, FloatVectors& q) const override;

  std::size_t levels() const { return levels_.size(); }

 private:
  struct Level {
    explicit Level(BlockRows block_rows);
    LevelMatrix matrix;
    BlockSweep sweep;
    // Right-hand side, solution, residual: four floats per particle. The finest level is given
    // those of the iterations.
    std::vector<float> b, z, r;
    // To the next coarser level, if there is one:
    Interpolation interpolation, restriction;
    std::optional<GalerkinProduct> product;
  };
  bool takeMatrix(const StepMatrix& matrix);
  /// z = (approximately) A^-1 b on a level; r is used up.
  void cycle(std::size_t level, const float* b, float* z, float* r);

  ThreadPool& threads_;
  std::vector<SymmetricBlock> row_sums_;
  double unit_ = 1.0;         // of the levels' matrices
  std::deque<Level> levels_;  // finest first
  std::optional<DenseCholesky> coarsest_;
};

}  // namespace mass_spring
