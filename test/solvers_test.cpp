#include <gtest/gtest.h>

#include "effects/effect.h"
#include "random_system.h"
#include "solvers/incomplete_cholesky.h"
#include "solvers/linear_system.h"

namespace mass_spring {
namespace {

/// What a linear system needs to know of a model.
Model modelOf(RandomSystem::Pattern pattern) {
  Model model;
  model.masses.setOnes(pattern->size());
  model.pattern = std::move(pattern);
  return model;
}

SolverOptions with(LinearSolver solver) {
  SolverOptions options;
  options.linear_solver = solver;
  return options;
}

TEST(BlockPattern, StoresEachPairOnce) {
  const auto pattern = RandomSystem::makePattern({{0, 1}, {1, 0}, {0, 1}, {2, 1}}, 4);
  EXPECT_EQ(pattern->blocks(), 2u);
  EXPECT_EQ(pattern->slot(1, 0), pattern->slot(0, 1));
  EXPECT_NE(pattern->slot(1, 2), pattern->slot(0, 1));
  EXPECT_EQ(pattern->nonzeros(), 9u * (4 + 2 * 2));
}

TEST(StepMatrix, MultipliesLikeItsDenseForm) {
  const RandomSystem s(randomGraph(25), 25);
  Vectors y(3, 25);
  s.matrix.multiply(s.b, y);
  const Eigen::VectorXd expected =
      s.dense * Eigen::Map<const Eigen::VectorXd>(s.b.data(), s.b.size());
  // 1e-13: rounding of sums of some 30 products of size 100.
  EXPECT_LT((Eigen::Map<const Eigen::VectorXd>(y.data(), y.size()) - expected).norm(),
            1e-13 * expected.norm());
}

TEST(StepMatrix, DecouplingLeavesTheFreeParticlesSystem) {
  RandomSystem s(randomGraph(12), 12);
  std::vector<char> pinned(12, 0);
  pinned[3] = pinned[7] = 1;
  s.matrix.decouple(pinned);
  Vectors x = Vectors::Zero(3, 12), y(3, 12);
  x.col(3).setConstant(5.0);
  s.matrix.multiply(x, y);
  for (Eigen::Index i = 0; i < 12; ++i) {
    EXPECT_EQ(y.col(i).norm() > 0.0, i == 3) << i;
  }
}

// Without fill the incomplete factor is complete but for the rounding of its floats: each iteration
// of conjugate gradients gains some six digits, where an incomplete one needs ten for as many.
TEST(IncompleteCholesky, IsExactForAChain) {
  const RandomSystem s(chain(30), 30);
  ConjugateGradient solver(std::make_unique<IncompleteCholesky>(s.pattern), s.pattern->size());
  solver.prepare(s.matrix);
  Vectors x = Vectors::Zero(3, 30);
  const LinearResult result = solver.solve(s.b, 1e-10, 10, x);
  EXPECT_TRUE(result.converged);
  EXPECT_LE(result.iterations, 2u);
}

// The hub of a star is eliminated first and would couple all its neighbors: 2e9 blocks.
TEST(IncompleteCholesky, LeavesOutTheFillOfAHub) {
  const std::uint32_t n = 60000;
  Pairs star;
  for (std::uint32_t i = 1; i < n; ++i) star.emplace_back(0, i);
  const RandomSystem::Pattern pattern = RandomSystem::makePattern(star, n);
  StepMatrix matrix(pattern);
  matrix.setMasses(1.0, Eigen::VectorXd::Constant(n, 1.0));
  for (const auto& [i, j] : star) {
    matrix.addElement(i, j, pattern->slot(i, j), SymmetricBlock::isotropic(1.0));
  }
  ConjugateGradient solver(std::make_unique<IncompleteCholesky>(pattern), n);
  solver.prepare(matrix);
  Vectors x = Vectors::Zero(3, n);
  EXPECT_TRUE(solver.solve(Vectors::Ones(3, n), 1e-6, 100, x).converged);
}

TEST(ConjugateGradient, ReachesItsToleranceAndSaysSo) {
  const RandomSystem s(randomGraph(60), 60);
  ConjugateGradient solver(std::make_unique<IncompleteCholesky>(s.pattern), s.pattern->size());
  solver.prepare(s.matrix);
  Vectors x = Vectors::Zero(3, 60);
  const LinearResult result = solver.solve(s.b, 1e-9, 500, x);
  ASSERT_TRUE(result.converged);
  EXPECT_GT(result.iterations, 3u);
  Vectors y(3, 60);
  s.matrix.multiply(x, y);
  EXPECT_EQ((s.b - y).norm() / s.b.norm(), result.residual);
  EXPECT_LE(result.residual, 1e-9);
}

TEST(ConjugateGradient, StartsFromWhatItIsGiven) {
  const RandomSystem s(randomGraph(60), 60);
  ConjugateGradient solver(std::make_unique<IncompleteCholesky>(s.pattern), s.pattern->size());
  solver.prepare(s.matrix);
  Vectors x = s.solution();
  EXPECT_EQ(solver.solve(s.b, 1e-9, 500, x).iterations, 0u);
  // From a multiple of it too: the start is scaled first.
  x = 1.5 * s.solution();
  EXPECT_EQ(solver.solve(s.b, 1e-9, 500, x).iterations, 0u);
}

TEST(ConjugateGradient, ReportsThatItWasStoppedEarly) {
  const RandomSystem s(randomGraph(60), 60);
  ConjugateGradient solver(std::make_unique<IncompleteCholesky>(s.pattern), s.pattern->size());
  solver.prepare(s.matrix);
  Vectors x = Vectors::Zero(3, 60);
  const LinearResult result = solver.solve(s.b, 1e-9, 2, x);
  EXPECT_FALSE(result.converged);
  EXPECT_EQ(result.iterations, 2u);
  EXPECT_GT(result.residual, 1e-9);
}

TEST(LinearSystem, ZeroRightHandSideNeedsNoWork) {
  const RandomSystem s(randomGraph(20), 20);
  for (LinearSolver solver :
       {LinearSolver::kConjugateGradient, LinearSolver::kCholesky, LinearSolver::kMultigrid}) {
    const Model model = modelOf(s.pattern);
    Workspace workspace(model);
    LinearSystem system(workspace, with(solver));
    Vectors x = s.b;
    const LinearSystem::Result result = system.solve(s.matrix, Vectors::Zero(3, 20), 1e-6, x);
    EXPECT_TRUE(result.converged);
    EXPECT_EQ(result.iterations + result.factorizations, 0u);
    EXPECT_EQ(x.norm(), 0.0);
  }
}

TEST(LinearSystem, FactorizesOnceForSeveralRightHandSides) {
  const RandomSystem s(randomGraph(30), 30);
  const Model model = modelOf(s.pattern);
  Workspace workspace(model);
  LinearSystem system(workspace, with(LinearSolver::kCholesky));
  system.prepare(s.matrix);
  std::uint32_t factorizations = 0;
  for (double scale : {0.0, 1.0, 2.0}) {
    Vectors x = Vectors::Zero(3, 30);
    const LinearSystem::Result result = system.solve(scale * s.b, 1e-10, x);
    EXPECT_TRUE(result.converged);
    factorizations += result.factorizations;
    // 1e-10: rounding times a condition number of some 1e3, with room.
    EXPECT_LE((x - scale * s.solution()).norm(), 1e-10 * x.norm());
  }
  EXPECT_EQ(factorizations, 1u);
}

TEST(LinearSystem, AutoSolvesAChainDirectly) {
  const Model model = modelOf(RandomSystem::makePattern(chain(10000), 10000));
  Workspace workspace(model);
  EXPECT_TRUE(LinearSystem(workspace, with(LinearSolver::kAuto)).direct());
}

TEST(LinearSystem, AutoFallsBackToTheDirectFactor) {
  // A grid large enough for conjugate gradients, which are then allowed a single iteration.
  Pairs grid;
  const std::uint32_t n = 60;
  for (std::uint32_t row = 0; row < n; ++row) {
    for (std::uint32_t column = 0; column < n; ++column) {
      const std::uint32_t i = row * n + column;
      for (std::uint32_t reach = 1; reach <= 2; ++reach) {
        if (column + reach < n) grid.emplace_back(i, i + reach);
        if (row + reach < n) grid.emplace_back(i, i + reach * n);
      }
      if (column + 1 < n && row + 1 < n) {
        grid.emplace_back(i, i + n + 1);
        grid.emplace_back(i + 1, i + n);
      }
    }
  }
  const auto pattern = RandomSystem::makePattern(grid, n * n);
  StepMatrix matrix(pattern);
  matrix.setMasses(1.0, Eigen::VectorXd::Constant(n * n, 0.01));
  for (const auto& [i, j] : grid) {
    matrix.addElement(i, j, pattern->slot(i, j), SymmetricBlock::isotropic(10.0));
  }
  SolverOptions options = with(LinearSolver::kAuto);
  options.max_linear_iterations = 1;
  const Model model = modelOf(pattern);
  Workspace workspace(model);
  LinearSystem system(workspace, options);
  ASSERT_FALSE(system.direct());
  const Vectors b = Vectors::Random(3, n * n);
  Vectors x = Vectors::Zero(3, n * n), y(3, n * n);
  const LinearSystem::Result result = system.solve(matrix, b, 1e-6, x);
  EXPECT_TRUE(result.converged);
  EXPECT_EQ(result.factorizations, 1u);
  matrix.multiply(x, y);
  EXPECT_LT((b - y).norm(), 1e-6 * b.norm());

  options.linear_solver = LinearSolver::kConjugateGradient;
  x.setZero();
  EXPECT_FALSE(LinearSystem(workspace, options).solve(matrix, b, 1e-6, x).converged);
}

}  // namespace
}  // namespace mass_spring
