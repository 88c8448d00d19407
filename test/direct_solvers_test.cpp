#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include "mass_spring_sim/simulation.h"
#include "random_system.h"
#include "solvers/ordering.h"
#include "solvers/sparse_cholesky.h"
#ifdef MASS_SPRING_WITH_CHOLMOD
#include "solvers/cholmod_cholesky.h"
#endif

namespace mass_spring {
namespace {

using Pattern = RandomSystem::Pattern;

struct Direct {
  std::string name;
  std::unique_ptr<DirectSolver> solver;
};

/// One of each that this build has.
std::vector<Direct> directSolvers(const Pattern& pattern) {
  std::vector<Direct> all;
  all.push_back(
      {"minimum degree", std::make_unique<SparseCholesky>(pattern, minimumDegreeOrder(*pattern))});
  all.push_back(
      {"band", std::make_unique<SparseCholesky>(pattern, reverseCuthillMcKeeOrder(*pattern))});
#ifdef MASS_SPRING_WITH_CHOLMOD
  all.push_back({"cholmod", std::make_unique<CholmodCholesky>(pattern, 0.0)});
#endif
  return all;
}

/// The same graph with its particles numbered at random.
Pairs shuffled(Pairs pairs, std::uint32_t n) {
  std::vector<std::uint32_t> number(n);
  std::iota(number.begin(), number.end(), 0u);
  std::shuffle(number.begin(), number.end(), std::mt19937(7));
  for (auto& [i, j] : pairs) i = number[i], j = number[j];
  return pairs;
}

Pairs ring(std::uint32_t n) {
  Pairs pairs = chain(n);
  pairs.emplace_back(n - 1, 0);
  return pairs;
}

Pairs star(std::uint32_t n) {
  Pairs pairs;
  for (std::uint32_t i = 1; i < n; ++i) pairs.emplace_back(0, i);
  return pairs;
}

/// Each particle hangs on one before it, chosen at random.
Pairs tree(std::uint32_t n) {
  std::mt19937 random(3);
  Pairs pairs;
  for (std::uint32_t i = 1; i < n; ++i) {
    pairs.emplace_back(i, std::uniform_int_distribution<std::uint32_t>(0, i - 1)(random));
  }
  return pairs;
}

/// n x n particles, joined as those of a cloth are.
Pairs sheet(std::uint32_t n) {
  Pairs pairs;
  for (std::uint32_t i = 0; i < n * n; ++i) {
    const std::uint32_t column = i % n, row = i / n;
    for (std::uint32_t reach = 1; reach <= 2; ++reach) {
      if (column + reach < n) pairs.emplace_back(i, i + reach);
      if (row + reach < n) pairs.emplace_back(i, i + reach * n);
    }
    if (column + 1 < n && row + 1 < n) {
      pairs.emplace_back(i, i + n + 1);
      pairs.emplace_back(i + 1, i + n);
    }
  }
  return pairs;
}

double bandedProducts(const Pairs& pairs, std::uint32_t n) {
  const Pattern pattern = RandomSystem::makePattern(pairs, n);
  return SparseCholesky(pattern, reverseCuthillMcKeeOrder(*pattern)).blockProducts();
}

double sparseProducts(const Pairs& pairs, std::uint32_t n) {
  const Pattern pattern = RandomSystem::makePattern(pairs, n);
  return SparseCholesky(pattern, minimumDegreeOrder(*pattern)).blockProducts();
}

TEST(DirectSolvers, SolveAnyGraph) {
  struct Case {
    const char* name;
    Pairs pairs;
    std::uint32_t n;
  };
  const Case cases[] = {{"one particle", {}, 1},
                        {"no springs", {}, 7},
                        {"two particles", {{1, 0}}, 2},
                        {"loose particles", {{3, 9}, {9, 4}}, 12},
                        {"net", randomGraph(40), 40},
                        {"chain", shuffled(chain(50, 2), 50), 50},
                        {"ring", shuffled(ring(50), 50), 50},
                        {"star", shuffled(star(50), 50), 50},
                        {"tree", tree(60), 60},
                        {"sheet", sheet(9), 81}};
  for (const Case& c : cases) {
    const RandomSystem s(c.pairs, c.n);
    for (const Direct& direct : directSolvers(s.pattern)) {
      ASSERT_TRUE(direct.solver->factorize(s.matrix)) << c.name << ", " << direct.name;
      Vectors x(3, c.n);
      direct.solver->solve(s.b, x);
      // 1e-11: rounding times a condition number of some 1e3.
      EXPECT_LT((x - s.solution()).norm(), 1e-11 * x.norm()) << c.name << ", " << direct.name;
    }
  }
}

TEST(DirectSolvers, RefuseWhatIsNotDefiniteAndRecover) {
  const RandomSystem s(randomGraph(20), 20);
  for (const double bad : {-1e4, std::numeric_limits<double>::quiet_NaN()}) {
    StepMatrix matrix = s.matrix;
    const std::uint32_t other = s.pattern->column(s.pattern->rowStart(4));
    matrix.addElement(4, other, s.pattern->slot(4, other), SymmetricBlock::isotropic(bad));
    for (const Direct& direct : directSolvers(s.pattern)) {
      // What BLAS does with a NaN depends on whose it is: then the residual tells.
      if (direct.name != "cholmod" || bad < 0.0) {
        EXPECT_FALSE(direct.solver->factorize(matrix)) << direct.name << ", " << bad;
      } else {
        direct.solver->factorize(matrix);
      }
      ASSERT_TRUE(direct.solver->factorize(s.matrix)) << direct.name;
      Vectors x(3, 20);
      direct.solver->solve(s.b, x);
      EXPECT_LT((x - s.solution()).norm(), 1e-11 * x.norm()) << direct.name;
    }
  }
}

// Eliminating a link updates each of the `reach` that follow it: reach (reach + 1) / 2 products,
// and fewer at the end of the chain.
TEST(DirectSolvers, NeedLinearWorkForAChainHoweverItIsNumbered) {
  for (const std::uint32_t n : {10u, 100u, 10000u}) {
    EXPECT_EQ(bandedProducts(chain(n), n), n - 1.0);
    EXPECT_EQ(bandedProducts(shuffled(chain(n), n), n), n - 1.0);
    EXPECT_EQ(sparseProducts(shuffled(chain(n), n), n), n - 1.0);
    EXPECT_EQ(bandedProducts(shuffled(chain(n, 2), n), n), 3.0 * (n - 2) + 1.0);
  }
}

TEST(DirectSolvers, FillInNothingOnATree) {
  EXPECT_EQ(sparseProducts(star(2000), 2000), 1999.0);
  const double products = sparseProducts(tree(2000), 2000);
  EXPECT_LT(products, 2.0 * 2000) << "one product per particle, and one more where it has a parent";
}

TEST(Ordering, NumbersEachParticleOnce) {
  Pairs pairs = sheet(6);  // particles 36 to 49 stand alone
  pairs.emplace_back(44, 40);
  const Pattern pattern = RandomSystem::makePattern(shuffled(pairs, 50), 50);
  for (auto order : {minimumDegreeOrder(*pattern), reverseCuthillMcKeeOrder(*pattern)}) {
    std::sort(order.begin(), order.end());
    for (std::uint32_t k = 0; k < 50; ++k) EXPECT_EQ(order.at(k), k);
  }
}

TEST(Ordering, TellsTheWorkOfABand) {
  const auto estimate = [](const Pairs& pairs, std::uint32_t n) {
    const Pattern pattern = RandomSystem::makePattern(pairs, n);
    return bandProducts(*pattern, reverseCuthillMcKeeOrder(*pattern));
  };
  EXPECT_EQ(estimate(shuffled(chain(80, 3), 80), 80), bandedProducts(chain(80, 3), 80));
  // The fill stays within the band.
  EXPECT_GE(estimate(sheet(10), 100), bandedProducts(sheet(10), 100));
}

TEST(DirectSolvers, AreChosenByTheirWork) {
  const auto products = [](LinearSolver solver, const Pairs& pairs, std::uint32_t n) {
    return makeDirectSolver(solver, RandomSystem::makePattern(pairs, n))->blockProducts();
  };
  const Pairs rope = shuffled(chain(200, 6), 200), cloth = sheet(30);
  EXPECT_EQ(products(LinearSolver::kAuto, rope, 200), bandedProducts(rope, 200));
  EXPECT_EQ(products(LinearSolver::kAuto, cloth, 900), sparseProducts(cloth, 900));
  EXPECT_EQ(products(LinearSolver::kBanded, cloth, 900), bandedProducts(cloth, 900));
  EXPECT_EQ(products(LinearSolver::kCholesky, rope, 200), sparseProducts(rope, 200));
  EXPECT_GT(bandedProducts(cloth, 900), sparseProducts(cloth, 900));
}

// Of the size from which CHOLMOD is taken where it is there; else the two are the same.
TEST(DirectSolvers, AgreeOnLargeFill) {
  const std::uint32_t n = 48;
  const Pattern pattern = RandomSystem::makePattern(sheet(n), n * n);
  StepMatrix matrix(pattern);
  matrix.setMasses(1.0, Eigen::VectorXd::Constant(n * n, 0.01));
  for (const auto& [i, j] : sheet(n)) {
    matrix.addElement(i, j, pattern->slot(i, j), SymmetricBlock::isotropic(10.0));
  }
  const Vectors b = Vectors::Random(3, n * n);
  Vectors own(3, n * n), chosen(3, n * n);
  SparseCholesky reference(pattern, minimumDegreeOrder(*pattern));
  ASSERT_TRUE(reference.factorize(matrix));
  reference.solve(b, own);
  const auto solver = makeDirectSolver(LinearSolver::kCholesky, pattern);
  ASSERT_TRUE(solver->factorize(matrix));
  solver->solve(b, chosen);
  // 1e-10: rounding times a condition number of up to 1e5.
  EXPECT_LT((chosen - own).norm(), 1e-10 * own.norm());
#ifdef MASS_SPRING_WITH_CHOLMOD
  EXPECT_NE(dynamic_cast<CholmodCholesky*>(solver.get()), nullptr);
#else
  EXPECT_NE(dynamic_cast<SparseCholesky*>(solver.get()), nullptr);
#endif
}

Scene swingingRope(int links, LinearSolver solver) {
  Rope cable;
  cable.start = Eigen::Vector3d::Zero();
  cable.end = Eigen::Vector3d(0.01 * links, 0, 0);
  cable.segments = links;
  cable.mass = 0.001 * links;
  cable.stiffness = 1e4;
  cable.bend_stiffness = 10.0;
  Scene scene;
  scene.rate = 60.0;
  scene.solver.scheme = Scheme::kImplicitEuler;
  scene.solver.linear_solver = solver;
  scene.objects.push_back({"cable", Eigen::Vector4d(1, 1, 1, 1), cable});
  scene.effects.gravity = GravityOptions{Eigen::Vector3d(0, 0, -9.81)};
  pin(scene, {0});
  return scene;
}

void expectSameMotion(const Scene& scene, LinearSolver other) {
  Scene banded_scene = scene, other_scene = scene;
  banded_scene.solver.linear_solver = LinearSolver::kBanded;
  other_scene.solver.linear_solver = other;
  Simulation banded(banded_scene), reference(other_scene);
  for (int step = 0; step < 5; ++step) {
    const StepReport report = banded.step();
    reference.step();
    EXPECT_EQ(report.status, StepStatus::kConverged) << report.message;
    EXPECT_EQ(report.linear_iterations, 0u);
    EXPECT_GE(report.factorizations, 1u);
  }
  const Vectors moved = reference.state().positions - reference.model().start.positions;
  const Vectors difference = banded.state().positions - reference.state().positions;
  // 1e-4: Newton's tolerance of 1e-6 in each of five steps, of links a hundredth of the way long.
  EXPECT_LT(difference.norm(), 1e-4 * moved.norm());
}

TEST(Banded, MovesARopeAsTheOthersDo) {
  for (const LinearSolver other : {LinearSolver::kCholesky, LinearSolver::kConjugateGradient}) {
    expectSameMotion(swingingRope(100, LinearSolver::kBanded), other);
  }
}

TEST(Banded, WorksOnACloth) {
  expectSameMotion(hangingCloth(12, Scheme::kLinearImplicitEuler), LinearSolver::kCholesky);
}

TEST(Banded, StepsARopeOfTenThousandLinks) {
  Simulation rope(swingingRope(10000, LinearSolver::kBanded));
  const StepReport report = rope.step();
  EXPECT_EQ(report.status, StepStatus::kConverged) << report.message;
  // The forces change little within this step: few factorizations, and no more than iterations.
  EXPECT_LE(report.factorizations, report.newton_iterations);
  EXPECT_LE(report.newton_iterations, 10u);
}

}  // namespace
}  // namespace mass_spring
