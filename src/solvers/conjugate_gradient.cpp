#include "solvers/conjugate_gradient.h"

#include <cmath>

namespace mass_spring {

ConjugateGradient::ConjugateGradient(std::shared_ptr<const BlockPattern> pattern)
    : preconditioner_(pattern),
      r_(3, pattern->size()),
      z_(3, pattern->size()),
      p_(3, pattern->size()),
      q_(3, pattern->size()) {}

void ConjugateGradient::prepare(const StepMatrix& matrix) {
  matrix_ = &matrix;
  factorized_ = false;
}

LinearResult ConjugateGradient::solve(const Vectors& b, double tolerance,
                                      std::uint32_t max_iterations, Vectors& x) {
  const StepMatrix& matrix = *matrix_;
  LinearResult result;
  const double b_norm = b.norm();
  if (b_norm == 0.0) {
    x.setZero();
    result.converged = true;
    return result;
  }
  matrix.multiply(x, q_);
  r_ = b - q_;
  double r_norm = r_.norm();
  result.residual = r_norm / b_norm;
  if (result.residual <= tolerance) {
    result.converged = true;
    return result;
  }
  if (!std::isfinite(r_norm)) return result;
  if (!factorized_) factorized_ = preconditioner_.factorize(matrix);
  if (!factorized_) return result;

  double rho_before = 1.0;
  while (result.iterations < max_iterations) {
    preconditioner_.apply(r_, z_);
    const double rho = r_.cwiseProduct(z_).sum();
    // Not above zero: the matrix or its factor is not definite, or not finite.
    if (!(rho > 0.0)) break;
    if (result.iterations == 0) {
      p_ = z_;
    } else {
      p_ = z_ + (rho / rho_before) * p_;
    }
    rho_before = rho;
    matrix.multiply(p_, q_);
    const double curvature = p_.cwiseProduct(q_).sum();
    if (!(curvature > 0.0)) {
      result.indefinite = true;
      break;
    }
    const double alpha = rho / curvature;
    x += alpha * p_;
    r_ -= alpha * q_;
    ++result.iterations;
    r_norm = r_.norm();
    result.residual = r_norm / b_norm;
    if (result.residual <= tolerance) {
      result.converged = true;
      break;
    }
  }
  return result;
}

}  // namespace mass_spring
