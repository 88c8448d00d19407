#include "solvers/conjugate_gradient.h"

#include <cmath>

namespace mass_spring {
namespace {

// As far as the residual may fall before it is computed anew: floats carry it for seven digits.
constexpr double kCarried = 1e-3;
// Where it then proves this many times as large as it was carried, floats do not serve.
constexpr double kMisled = 2.0;

// The start is the multiple of what is given that is nearest to the solution in the norm of A,
// unless that is not near 1.
constexpr double kMostScaled = 2.0;

template <typename V>
constexpr std::size_t kStride = V::RowsAtCompileTime;  // of which three count

/// @return a . b
template <typename A, typename B>
double dot(const A& a, const B& b, std::size_t begin, std::size_t end) {
  double sum[3] = {0.0, 0.0, 0.0};
  for (std::size_t i = begin; i < end; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      sum[k] += a.data()[kStride<A> * i + k] * b.data()[kStride<B> * i + k];
    }
  }
  return sum[0] + sum[1] + sum[2];
}

/// p = share z + beta p
template <typename V>
void turn(double share, const FloatVectors& z, double beta, std::size_t begin, std::size_t end,
          V& p) {
  using T = typename V::Scalar;
  const T s = static_cast<T>(share), b = static_cast<T>(beta);
  for (std::size_t i = begin; i < end; ++i) {
    for (std::size_t k = 0; k < kStride<V>; ++k) {
      T& to = p.data()[kStride<V> * i + k];
      to = s * z.data()[4 * i + k] + b * to;
    }
  }
}

/// to = scale from
void shrink(const Vectors& from, double scale, std::size_t begin, std::size_t end,
            FloatVectors& to) {
  for (std::size_t i = begin; i < end; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      to.data()[4 * i + k] = static_cast<float>(scale * from.data()[3 * i + k]);
    }
  }
}

/// x += a p, r -= b q. @return |r|^2
template <typename V>
double advance(double a, const V& p, double b, const V& q, std::size_t begin, std::size_t end,
               Vectors& x, Vectors& r) {
  double sum[3] = {0.0, 0.0, 0.0};
  for (std::size_t i = begin; i < end; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      x.data()[3 * i + k] += a * p.data()[kStride<V> * i + k];
      const double rest = r.data()[3 * i + k] - b * q.data()[kStride<V> * i + k];
      r.data()[3 * i + k] = rest;
      sum[k] += rest * rest;
    }
  }
  return sum[0] + sum[1] + sum[2];
}

}  // namespace

ConjugateGradient::ConjugateGradient(std::unique_ptr<Preconditioner> preconditioner,
                                     std::uint32_t size)
    : preconditioner_(std::move(preconditioner)), r_(3, size) {
  for (FloatVectors* v : {&scaled_r_, &z_, &p_, &q_}) v->setZero(4, size);
  for (Vectors* v : {&exact_p_, &exact_q_}) v->setZero(3, size);
}

void ConjugateGradient::prepare(const StepMatrix& matrix) {
  matrix_ = &matrix;
  prepared_ = false;
  in_floats_ = preconditioner_->multiplies();
}

template <typename Work>
double ConjugateGradient::sumOverHalves(const Work& work) const {
  double sums[2] = {0.0, 0.0};
  matrix_->inHalves([&](std::uint32_t part, std::uint32_t begin, std::uint32_t end) {
    sums[part] = work(begin, end);
  });
  return sums[0] + sums[1];
}

double ConjugateGradient::findResidual(const Vectors& b, const Vectors& x) {
  matrix_->multiply(x, r_);
  r_ = b - r_;
  return r_.norm();
}

double ConjugateGradient::multiply(const FloatVectors& p, FloatVectors& q) const {
  const double unit = preconditioner_->multiply(p, q);
  matrix_->addTies(1.0 / unit, p, q);
  return unit;
}

double ConjugateGradient::multiply(const Vectors& p, Vectors& q) const {
  matrix_->multiply(p, q);
  return 1.0;
}

LinearResult ConjugateGradient::solve(const Vectors& b, double tolerance,
                                      std::uint32_t max_iterations, Vectors& x) {
  LinearResult result;
  const double b_norm = b.norm();
  if (b_norm == 0.0) {
    x.setZero();
    result.converged = true;
    return result;
  }
  r_ = b;
  if (!x.isZero(0.0)) {
    matrix_->multiply(x, exact_q_);
    const double share = x.cwiseProduct(b).sum() / x.cwiseProduct(exact_q_).sum();
    if (share > 1.0 / kMostScaled && share < kMostScaled) {
      x *= share;
      r_ -= share * exact_q_;
    } else {
      x.setZero();  // what leads elsewhere, after a reset or a teleport, is worse than nothing
    }
  }
  double computed = r_.norm();  // when it was last found from x
  result.residual = computed / b_norm;
  if (result.residual <= tolerance) {
    result.converged = true;
    return result;
  }
  if (!std::isfinite(computed)) return result;
  if (!prepared_) prepared_ = preconditioner_->prepare(*matrix_);
  if (!prepared_) {
    result.indefinite = true;
    return result;
  }

  Progress progress{computed, computed, 0.0};
  while (result.iterations < max_iterations) {
    const bool advanced =
        in_floats_ ? iterate(p_, q_, x, progress) : iterate(exact_p_, exact_q_, x, progress);
    if (!advanced) break;
    ++result.iterations;
    result.residual = progress.norm / b_norm;
    if (result.residual > tolerance && progress.norm > kCarried * computed) continue;
    computed = findResidual(b, x);
    result.residual = computed / b_norm;
    if (result.residual <= tolerance) {
      result.converged = true;
      break;
    }
    if (!(computed <= kMisled * progress.norm)) {
      in_floats_ = false;
      progress.rho_before = 0.0;
    }
    progress.norm = computed;
  }
  result.indefinite = progress.indefinite;
  return result;
}

template <typename V>
bool ConjugateGradient::iterate(V& p, V& q, Vectors& x, Progress& progress) {
  // Floats hold the residual in units of its present norm, directions in those of the first.
  const double share = progress.norm / progress.unit;
  sumOverHalves([&](std::uint32_t begin, std::uint32_t end) {
    shrink(r_, 1.0 / progress.norm, begin, end, scaled_r_);
    return 0.0;
  });
  preconditioner_->apply(scaled_r_, z_, q_);
  const double rho = share * share * sumOverHalves([&](std::uint32_t begin, std::uint32_t end) {
                       return dot(scaled_r_, z_, begin, end);
                     });
  // Not above zero: the matrix or its factor is not definite, or not finite.
  if (!(rho > 0.0)) return false;
  const double beta = progress.rho_before > 0.0 ? rho / progress.rho_before : 0.0;
  progress.rho_before = rho;
  if (beta == 0.0) p.setZero();
  sumOverHalves([&](std::uint32_t begin, std::uint32_t end) {
    turn(share, z_, beta, begin, end, p);
    return 0.0;
  });
  const double unit = multiply(p, q);
  const double curvature = unit * sumOverHalves([&](std::uint32_t begin, std::uint32_t end) {
                             return dot(p, q, begin, end);
                           });
  if (!(curvature > 0.0)) {
    progress.indefinite = true;
    return false;
  }
  const double alpha = progress.unit * rho / curvature;
  progress.norm = std::sqrt(sumOverHalves([&](std::uint32_t begin, std::uint32_t end) {
    return advance(alpha, p, alpha * unit, q, begin, end, x, r_);
  }));
  return true;
}

}  // namespace mass_spring
