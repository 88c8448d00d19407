#include "solvers/linear_system.h"

#include <algorithm>

#include "effects/effect.h"
#include "solvers/factor_preconditioner.h"
#include "solvers/incomplete_cholesky.h"
#include "solvers/multigrid.h"

namespace mass_spring {
namespace {

// Block products of one factorization per block of the matrix, up to which it is taken instead of
// conjugate gradients. Measured on the hanging cloth of n x n particles (18 at n = 10, 38 at n =
// 15): the two break even at n = 9 with the stiffness of the benchmark and at n = 16 with 1000
// times that.
constexpr double kDirectWorkPerBlock = 25.0;
// Factors beyond this size (some 10 s of work) are no rescue for a simulation that has to go on.
constexpr double kLargestRescue = 5e8;
// Conjugate gradients that take longer than the factor would have are given up.
constexpr double kLeastPatience = 100.0;       // iterations
constexpr std::uint32_t kLongestSeries = 256;  // of matrices that are not even tried

}  // namespace

LinearSystem::LinearSystem(Workspace& workspace, const SolverOptions& options)
    : options_(options),
      direct_(options.linear_solver == LinearSolver::kCholesky ||
              options.linear_solver == LinearSolver::kBanded) {
  const Model& model = workspace.model();
  const std::shared_ptr<const BlockPattern>& pattern = model.pattern;
  if (options_.linear_solver != LinearSolver::kConjugateGradient) {
    direct_solver_ = makeDirectSolver(options_.linear_solver, pattern);
    if (options_.linear_solver == LinearSolver::kAuto) {
      const double blocks = pattern->size() + pattern->blocks();
      direct_ = direct_solver_->blockProducts() < kDirectWorkPerBlock * blocks;
    }
  }
  if (direct_) {
    direct_solver_->reserve();
  } else {
    std::unique_ptr<Preconditioner> preconditioner;
    if (options.linear_solver == LinearSolver::kConjugateGradient) {
      preconditioner = std::make_unique<IncompleteCholesky>(pattern);
    } else {
      preconditioner = std::make_unique<Multigrid>(model, workspace.threads());
    }
    conjugate_gradient_.emplace(std::move(preconditioner), pattern->size());
    most_iterations_ = static_cast<std::uint32_t>(options.max_linear_iterations);
    if (direct_solver_ && direct_solver_->blockProducts() > kLargestRescue) direct_solver_.reset();
    if (direct_solver_) {
      // An iteration costs about as much as one product with each block that there is.
      const double blocks = pattern->size() + pattern->blocks();
      const double patience = direct_solver_->blockProducts() / blocks;
      most_iterations_ = std::min(most_iterations_,
                                  static_cast<std::uint32_t>(std::max(patience, kLeastPatience)));
    }
  }
  if (direct_solver_) {
    residual_.resize(3, pattern->size());
    correction_.resize(3, pattern->size());
    const auto ties = [](const auto& effect) { return effect->traits().ties; };
    if (std::any_of(model.effects.begin(), model.effects.end(), ties)) {
      led_by_factor_.emplace(
          std::make_unique<FactorPreconditioner>(*direct_solver_, pattern->size()),
          pattern->size());
    }
  }
}

void LinearSystem::restart() {
  direct_for_ = 0;
  direct_for_next_ = 1;
}

void LinearSystem::prepare(const StepMatrix& matrix) {
  matrix_ = &matrix;
  factorized_ = false;
  if (direct_for_ > 0) --direct_for_;
  if (conjugate_gradient_) conjugate_gradient_->prepare(matrix);
  if (led_by_factor_) led_by_factor_->prepare(matrix);
}

LinearSystem::Result LinearSystem::solve(const StepMatrix& matrix, const Vectors& b,
                                         double tolerance, Vectors& x) {
  prepare(matrix);
  return solve(b, tolerance, x);
}

LinearSystem::Result LinearSystem::solve(const Vectors& b, double tolerance, Vectors& x) {
  Result result;
  // A matrix that has once needed the direct factor keeps it for its other right-hand sides.
  if (direct_ || factorized_ || direct_for_ > 0) {
    solveDirectly(b, tolerance, x, result);
    return result;
  }
  const LinearResult iterative = conjugate_gradient_->solve(b, tolerance, most_iterations_, x);
  result.converged = iterative.converged;
  result.iterations = iterative.iterations;
  result.residual = iterative.residual;
  result.indefinite = iterative.indefinite;
  if (!result.converged && !result.indefinite && direct_solver_) {
    solveDirectly(b, tolerance, x, result);
    // This matrix keeps its factor; the count includes it.
    direct_for_ = direct_for_next_ + 1;
    direct_for_next_ = std::min(2 * direct_for_next_, kLongestSeries);
  } else if (result.converged && result.iterations > 0) {
    direct_for_next_ = 1;
  }
  return result;
}

void LinearSystem::solveDirectly(const Vectors& b, double tolerance, Vectors& x, Result& result) {
  const double b_norm = b.norm();
  if (b_norm == 0.0) {
    x.setZero();
    result.residual = 0.0;
    result.converged = true;
    return;
  }
  if (!factorized_) {
    ++result.factorizations;
    factorized_ = direct_solver_->factorize(*matrix_);
  }
  if (!factorized_) {
    result.indefinite = true;
    return;
  }
  if (!matrix_->ties().empty()) return solveByFactor(b, tolerance, x, result);
  direct_solver_->solve(b, x);
  matrix_->multiply(x, residual_);
  residual_ = b - residual_;
  double norm = residual_.norm();
  // Refinement wins back the digits that badly scaled blocks cost, until the error of this solution
  // does not matter beside those that the tolerance allows others.
  for (int round = 0; round < 3 && norm > 1e-3 * tolerance * b_norm; ++round) {
    direct_solver_->solve(residual_, correction_);
    correction_ += x;
    matrix_->multiply(correction_, residual_);
    residual_ = b - residual_;
    const double refined = residual_.norm();
    if (!(refined < norm)) break;
    norm = refined;
    x.swap(correction_);
  }
  result.residual = norm / b_norm;
  result.converged = result.residual <= tolerance;
}

void LinearSystem::solveByFactor(const Vectors& b, double tolerance, Vectors& x, Result& result) {
  const auto most = static_cast<std::uint32_t>(options_.max_linear_iterations);
  const LinearResult led = led_by_factor_->solve(b, tolerance, most, x);
  result.converged = led.converged;
  result.iterations += led.iterations;
  result.residual = led.residual;
  result.indefinite = led.indefinite;
}

}  // namespace mass_spring
