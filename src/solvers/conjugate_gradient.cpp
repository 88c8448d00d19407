#include "solvers/conjugate_gradient.h"

#include <cmath>

namespace mass_spring {

ConjugateGradient::ConjugateGradient(std::unique_ptr<Preconditioner> preconditioner,
                                     std::uint32_t size)
    : preconditioner_(std::move(preconditioner)),
      r_(3, size),
      z_(3, size),
      p_(3, size),
      q_(3, size) {}

void ConjugateGradient::prepare(const StepMatrix& matrix) {
  matrix_ = &matrix;
  prepared_ = false;
}

template <typename Work>
double ConjugateGradient::sumOverHalves(const Work& work) const {
  double sums[2] = {0.0, 0.0};
  matrix_->inHalves([&](std::uint32_t part, Eigen::Index begin, Eigen::Index end) {
    sums[part] = work(begin, end - begin);
  });
  return sums[0] + sums[1];
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
  if (r_norm > b_norm) {  // a start that leads away, after a reset or a teleport: zero is better
    x.setZero();
    r_ = b;
    r_norm = b_norm;
  }
  result.residual = r_norm / b_norm;
  if (result.residual <= tolerance) {
    result.converged = true;
    return result;
  }
  if (!std::isfinite(r_norm)) return result;
  if (!prepared_) prepared_ = preconditioner_->prepare(matrix);
  if (!prepared_) {
    result.indefinite = true;
    return result;
  }

  double rho_before = 1.0;
  while (result.iterations < max_iterations) {
    const double rho = preconditioner_->apply(r_, z_);
    // Not above zero: the matrix or its factor is not definite, or not finite.
    if (!(rho > 0.0)) break;
    const double beta = result.iterations == 0 ? 0.0 : rho / rho_before;
    sumOverHalves([&](Eigen::Index first, Eigen::Index columns) {
      if (beta == 0.0) {
        p_.middleCols(first, columns) = z_.middleCols(first, columns);
      } else {
        p_.middleCols(first, columns) =
            z_.middleCols(first, columns) + beta * p_.middleCols(first, columns);
      }
      return 0.0;
    });
    rho_before = rho;
    matrix.multiply(p_, q_);
    const double curvature = sumOverHalves([&](Eigen::Index first, Eigen::Index columns) {
      return p_.middleCols(first, columns).cwiseProduct(q_.middleCols(first, columns)).sum();
    });
    if (!(curvature > 0.0)) {
      result.indefinite = true;
      break;
    }
    const double alpha = rho / curvature;
    r_norm = std::sqrt(sumOverHalves([&](Eigen::Index first, Eigen::Index columns) {
      x.middleCols(first, columns) += alpha * p_.middleCols(first, columns);
      r_.middleCols(first, columns) -= alpha * q_.middleCols(first, columns);
      return r_.middleCols(first, columns).squaredNorm();
    }));
    ++result.iterations;
    result.residual = r_norm / b_norm;
    if (result.residual <= tolerance) {
      result.converged = true;
      break;
    }
  }
  return result;
}

}  // namespace mass_spring
