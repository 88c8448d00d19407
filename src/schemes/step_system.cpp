#include "schemes/step_system.h"

#include <cmath>

namespace mass_spring {

StepSystem::StepSystem(const Model& model, const SolverOptions& options)
    : model_(model), matrix_(model.pattern, model.threads.get()), system_(model, options) {}

void StepSystem::assemble(double w, const Vectors& x, const Vectors& x_damping,
                          Projection projection, SubstepReport& report) {
  matrix_.setMasses(1.0, model_.masses);
  const auto add = [&](const Vectors& positions, const MatrixWeights& weights) {
    for (const auto& effect : model_.effects) {
      report.projected_springs += effect->addDerivatives(positions, weights, projection, matrix_);
    }
  };
  if (&x == &x_damping) {
    add(x, {1.0, w, w * w});
  } else {
    add(x, {1.0, 0.0, w * w});
    add(x_damping, {1.0, w, 0.0});
  }
  ++report.newton_iterations;
}

void StepSystem::decouple(const std::vector<char>& pinned) {
  matrix_.decouple(pinned);
  system_.prepare(matrix_);
}

void StepSystem::shift(double share) {
  matrix_.shift(share);
  system_.prepare(matrix_);
}

void StepSystem::divideByDiagonal(const Vectors& b, Vectors& x) const {
  for (Eigen::Index i = 0; i < b.cols(); ++i) {
    const SymmetricBlock& d = matrix_.diagonal()[static_cast<std::size_t>(i)];
    x.col(i) = b.col(i) / (d.xx + d.yy + d.zz);
  }
}

LinearSystem::Result StepSystem::solve(const Vectors& b, double tolerance, Vectors& x,
                                       SubstepReport& report) {
  const LinearSystem::Result result = system_.solve(b, tolerance, x);
  report.linear_iterations += result.iterations;
  report.factorizations += result.factorizations;
  return result;
}

void clearPinned(const Drive& drive, Vectors& a) {
  for (Eigen::Index i = 0; i < a.cols(); ++i) {
    if (drive.isPinned(i)) a.col(i).setZero();
  }
}

double rootMeanSquare(const Drive& drive, const Vectors& a) {
  double sum = 0.0;
  Eigen::Index free = 0;
  for (Eigen::Index i = 0; i < a.cols(); ++i) {
    if (drive.isPinned(i)) continue;
    sum += a.col(i).squaredNorm();
    ++free;
  }
  return free > 0 ? std::sqrt(sum / static_cast<double>(free)) : 0.0;
}

}  // namespace mass_spring
