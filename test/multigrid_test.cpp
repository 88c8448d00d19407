#include "solvers/multigrid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "effects/effect.h"
#include "mass_spring_sim/simulation.h"
#include "probe.h"
#include "problems.h"
#include "shapes.h"
#include "solvers/conjugate_gradient.h"
#include "solvers/linear_system.h"
#include "solvers/ordering.h"
#include "solvers/sparse_cholesky.h"

namespace mass_spring {
namespace {

/// The step matrix of a scene whose particles have been moved a little, so that springs are
/// stretched, tilted and (a few) compressed; and a random right-hand side.
struct System {
  Model model;
  mutable ThreadPool threads;
  StepMatrix matrix;
  Vectors b;

  System(const Scene& scene, const std::vector<std::uint32_t>& pinned, double h = 1.0 / 60.0)
      : model(buildModel(scene)),
        threads(model.threads),
        matrix(model.pattern),
        b(3, model.particleCount()) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    Vectors positions = 1.02 * model.start.positions;
    double length = 0.0;
    for (const Spring& spring : model.springs) length += spring.rest_length;
    length /= static_cast<double>(std::max<std::size_t>(model.springs.size(), 1));
    for (Eigen::Index k = 0; k < b.size(); ++k) {
      positions.data()[k] += 0.05 * length * unit(random);
      b.data()[k] = unit(random);
    }
    matrix.setMasses(1.0, model.masses);
    for (const auto& effect : model.effects) {
      Probe(*effect, model.start.effects)
          .addDerivatives(positions, model.start.velocities, {1.0, h, h * h},
                          Projection::kWhereNeeded, matrix);
    }
    std::vector<char> mask(model.particleCount(), 0);
    for (std::uint32_t i : pinned) {
      mask[i] = 1;
      b.col(i).setZero();
    }
    matrix.decouple(mask);
  }

  Vectors exact() const {
    SparseCholesky cholesky(model.pattern, minimumDegreeOrder(*model.pattern));
    EXPECT_TRUE(cholesky.factorize(matrix));
    Vectors x(3, b.cols());
    cholesky.solve(b, x);
    return x;
  }

  LinearResult solve(double tolerance, Vectors& x) const {
    ConjugateGradient solver(std::make_unique<Multigrid>(model, threads), model.particleCount());
    solver.prepare(matrix);
    x.setZero(3, b.cols());
    return solver.solve(b, tolerance, 300, x);
  }

  /// Solves to 1e-10 within some iterations, and as the direct factor does.
  void expectSolved(std::uint32_t most_iterations) const {
    Vectors x;
    const LinearResult result = solve(1e-10, x);
    EXPECT_TRUE(result.converged);
    EXPECT_LE(result.iterations, most_iterations);
    const Vectors expected = exact();
    // 1e-6: the tolerance times the condition numbers of these matrices, up to some 1e4.
    EXPECT_LE((x - expected).norm(), 1e-6 * expected.norm());
  }
};

FloatVectors inFloats(const Vectors& v) {
  FloatVectors result = FloatVectors::Zero(4, v.cols());
  result.topRows<3>() = v.cast<float>();
  return result;
}

double dot(const FloatVectors& a, const FloatVectors& b) {
  return a.topRows<3>().cast<double>().cwiseProduct(b.topRows<3>().cast<double>()).sum();
}

Scene sceneOf(std::vector<Object> objects) {
  Scene scene;
  scene.objects = std::move(objects);
  return scene;
}

Scene sceneOf(const decltype(Object::shape)& shape) {
  return sceneOf({{"thing", Eigen::Vector4d::Ones(), shape}});
}

/// A sheet of n x m particles as a mesh of triangles with jittered vertices, numbered at random.
Mesh jitteredMesh(std::uint32_t n, std::uint32_t m) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-0.3, 0.3);
  std::vector<std::uint32_t> number(n * m);
  for (std::uint32_t i = 0; i < n * m; ++i) number[i] = i;
  std::shuffle(number.begin(), number.end(), random);
  Mesh mesh;
  mesh.vertices.resize(n * m);
  for (std::uint32_t row = 0; row < m; ++row) {
    for (std::uint32_t column = 0; column < n; ++column) {
      mesh.vertices[number[row * n + column]] =
          0.02 * Eigen::Vector3d(column + unit(random), row + unit(random), unit(random));
      if (row + 1 == m || column + 1 == n) continue;
      const auto at = [&](std::uint32_t r, std::uint32_t c) { return number[r * n + c]; };
      mesh.triangles.push_back({at(row, column), at(row, column + 1), at(row + 1, column + 1)});
      mesh.triangles.push_back({at(row, column), at(row + 1, column + 1), at(row + 1, column)});
    }
  }
  mesh.mass = 0.2;
  mesh.stiffness = 1000.0;
  mesh.bend_stiffness = 50.0;
  return mesh;
}

/// A shape's particles and springs as a net by hand, with rest lengths of its own.
Particles byHand(const decltype(Object::shape)& shape) {
  Model model;
  appendObject({"thing", Eigen::Vector4d::Ones(), shape}, model);
  Particles net;
  net.rest_lengths.emplace();
  for (std::uint32_t i = 0; i < model.particleCount(); ++i) {
    net.positions.push_back(model.start.positions.col(i));
    net.velocities.push_back(Eigen::Vector3d::Zero());
    net.masses.push_back(model.masses[i]);
  }
  for (const Spring& spring : model.springs) {
    net.springs.push_back({spring.i, spring.j});
    net.stiffness.push_back(spring.stiffness);
    net.rest_lengths->push_back(spring.rest_length);
  }
  return net;
}

std::vector<std::uint32_t> everyNth(std::uint32_t step, std::uint32_t count) {
  std::vector<std::uint32_t> particles;
  for (std::uint32_t i = 0; i < count; i += step) particles.push_back(i);
  return particles;
}

TEST(Multigrid, SolvesGrids) {
  System(sceneOf(someCloth(20, 31)), {0, 19}).expectSolved(30);
  System(sceneOf(someCloth(50, 50)), {0, 49}).expectSolved(35);
  System(sceneOf(someLattice(9, 10, 11)), {0, 1, 2, 3}).expectSolved(30);
  System(sceneOf(someRope(300)), {0}).expectSolved(60);
}

TEST(Multigrid, SolvesWithPinsAnywhere) {
  const Scene scene = sceneOf(someCloth(30, 30));
  System(scene, {}).expectSolved(35);
  System(scene, {465}).expectSolved(35);
  System(scene, everyNth(1, 450)).expectSolved(35);
  System(scene, everyNth(2, 900)).expectSolved(35);
  System(scene, everyNth(7, 900)).expectSolved(35);
  System(scene, everyNth(1, 900)).expectSolved(1);
}

TEST(Multigrid, SolvesMeshes) { System(sceneOf(jitteredMesh(40, 30)), {5, 100}).expectSolved(60); }

TEST(Multigrid, SolvesNetsByHand) {
  const Particles net = byHand(someCloth(25, 25));
  System(sceneOf(net), {0, 24}).expectSolved(40);
  Particles scrambled = net;
  std::mt19937 random(5);
  std::shuffle(scrambled.positions.begin(), scrambled.positions.end(), random);
  System(sceneOf(scrambled), {0, 24}).expectSolved(150);
  Particles coincident = net;
  for (Eigen::Vector3d& position : coincident.positions) position.setConstant(0.5);
  System(sceneOf(coincident), {0, 24}).expectSolved(150);
  for (double& length : *coincident.rest_lengths) length = 0.0;
  System(sceneOf(coincident), {0, 24}).expectSolved(150);
}

TEST(Multigrid, SolvesSeveralObjectsAtOnce) {
  Particles dust;
  for (int i = 0; i < 100; ++i) {
    dust.positions.emplace_back(i, 0.0, 0.0);
    dust.velocities.push_back(Eigen::Vector3d::Zero());
    dust.masses.push_back(0.01 + i);
  }
  const Eigen::Vector4d white = Eigen::Vector4d::Ones();
  System(sceneOf({{"a", white, someCloth(15, 20)},
                  {"b", white, dust},
                  {"c", white, someLattice(5, 6, 7)},
                  {"d", white, byHand(jitteredMesh(12, 12))},
                  {"e", white, someRope(10)}}),
         {0, 14, 410})
      .expectSolved(60);
}

TEST(Multigrid, SolvesAThousandComponents) {
  std::vector<Object> objects;
  for (int i = 0; i < 1000; ++i) {
    Rope rope = someRope(3);
    rope.stiffness = 10.0 * (1 + i % 100);
    objects.push_back({"rope" + std::to_string(i), Eigen::Vector4d::Ones(), rope});
  }
  System(sceneOf(std::move(objects)), {0, 17, 400}).expectSolved(40);
}

TEST(Multigrid, SolvesAStar) {
  Particles star = byHand(someRope(1));
  for (std::uint32_t i = 2; i < 2000; ++i) {
    star.positions.push_back(Eigen::Vector3d::Random());
    star.velocities.push_back(Eigen::Vector3d::Zero());
    star.masses.push_back(0.1);
    star.springs.push_back({i, 0});
    star.stiffness.push_back(100.0);
    star.rest_lengths->push_back(1.0);
  }
  System(sceneOf(star), {}).expectSolved(30);
}

// The number of levels grows with the resolution, and the contrast between a smooth and a rough
// displacement with its square: plain conjugate gradients take N times the iterations.
TEST(Multigrid, NeedsHardlyMoreIterationsForAFinerCloth) {
  std::vector<double> iterations;
  for (const int n : {25, 50, 100}) {
    Scene scene = hangingCloth(n, Scheme::kLinearImplicitEuler);
    scene.solver.linear_solver = LinearSolver::kMultigrid;
    Simulation simulation(scene);
    for (int step = 0; step < 8; ++step) simulation.step();
    const StepTotals& totals = simulation.totals();
    EXPECT_EQ(totals.factorizations, 0u);
    iterations.push_back(static_cast<double>(totals.linear_iterations) /
                         static_cast<double>(totals.newton_iterations));
  }
  for (int finer : {1, 2}) EXPECT_LT(iterations[finer], std::sqrt(2.0) * iterations[finer - 1]);
  EXPECT_LT(iterations.back(), 20.0);
}

// Two probes see asymmetry and indefiniteness with certainty, but for chance.
TEST(Multigrid, IsSymmetricAndPositive) {
  const System systems[] = {System(sceneOf(someCloth(45, 40)), {0, 44}),
                            System(sceneOf(someLattice(8, 8, 8)), {}),
                            System(sceneOf(jitteredMesh(30, 40)), {7})};
  for (const System& system : systems) {
    Multigrid multigrid(system.model, system.threads);
    ASSERT_TRUE(multigrid.prepare(system.matrix));
    const Vectors other = system.b.cwiseProduct(system.b).rowwise().reverse();
    const FloatVectors r1 = inFloats(system.b), r2 = inFloats(other);
    FloatVectors z1 = r1, z2 = r2, work = r1;
    multigrid.apply(r1, z1, work);
    multigrid.apply(r2, z2, work);
    const double norm1 = dot(r1, z1), norm2 = dot(r2, z2);
    ASSERT_GT(norm1, 0.0);
    ASSERT_GT(norm2, 0.0);
    const double scale = std::sqrt(norm1 * norm2);
    // 2e-4: rounding of floats, 6e-8, times the contrast of stiffness and mass in these matrices,
    // some 1e3. A cycle whose way up is not its way down reversed is off by more than 1e-2.
    EXPECT_NEAR(dot(z1, r2) / scale, dot(z2, r1) / scale, 2e-4);
  }
}

// Its product is that of the matrix but for the rounding of floats, relative to what the springs
// between neighbors contribute, however small the sum.
TEST(Multigrid, MultipliesInFloatsWithoutCancellation) {
  const System system(sceneOf(someCloth(45, 40)), {0, 44});
  Multigrid multigrid(system.model, system.threads);
  ASSERT_TRUE(multigrid.prepare(system.matrix));
  // All particles alike: no spring is stretched, only masses (and the pins' springs) are left.
  const Vectors alike = Vectors::Ones(3, system.b.cols());
  for (const Vectors& p : {alike, system.b}) {
    FloatVectors q = inFloats(p);
    const double unit = multigrid.multiply(inFloats(p), q);
    Vectors expected = p;
    system.matrix.multiply(p, expected);
    const Vectors found = unit * q.topRows<3>().cast<double>();
    EXPECT_LE((found - expected).norm(), 1e-6 * expected.norm());
  }
}

TEST(Multigrid, IsDeterministicOnOneThreadAndOnTwo) {
  std::vector<Vectors> results;
  for (const int threads : {1, 1, 2, 2}) {
    Scene scene = hangingCloth(40, Scheme::kLinearImplicitEuler);
    scene.solver.linear_solver = LinearSolver::kMultigrid;
    scene.solver.threads = threads;
    Simulation simulation(scene);
    for (int step = 0; step < 10; ++step) simulation.step();
    results.push_back(simulation.state().positions);
  }
  EXPECT_EQ(results[0], results[1]);
  EXPECT_EQ(results[2], results[3]);
  // Work is split in two halves whoever does them.
  EXPECT_EQ(results[0], results[2]);
}

TEST(Multigrid, ReportsAnIndefiniteMatrix) {
  System system(sceneOf(someCloth(30, 30)), {0, 29});
  // Softer than rigid along one pair: seen by the diagonal, or by the first directions.
  for (const double stiffness : {-5.0, -1e4}) {
    StepMatrix matrix = system.matrix;
    matrix.addElement(400, 401, system.model.pattern->slot(400, 401),
                      SymmetricBlock::isotropic(stiffness));
    Workspace workspace(system.model);
    LinearSystem solver(workspace, [] {
      SolverOptions options;
      options.linear_solver = LinearSolver::kMultigrid;
      return options;
    }());
    Vectors x = Vectors::Zero(3, system.b.cols());
    const LinearSystem::Result result = solver.solve(matrix, system.b, 1e-8, x);
    EXPECT_TRUE(result.indefinite) << stiffness;
    EXPECT_FALSE(result.converged);
    EXPECT_TRUE(x.allFinite());
    // And is none the worse for it.
    x.setZero();
    EXPECT_TRUE(solver.solve(system.matrix, system.b, 1e-8, x).converged);
  }
}

// Where particles next to each other differ by many decades, floats no longer see the soft ones.
TEST(Multigrid, LeavesStrongContrastsToTheDirectFactor) {
  Particles net = byHand(someCloth(25, 25));
  std::mt19937 random(5);
  std::uniform_real_distribution<double> exponent(0.0, 1.0);
  for (double& stiffness : net.stiffness) stiffness = std::pow(10.0, 10.0 * exponent(random));
  for (double& mass : net.masses) mass = std::pow(10.0, -6.0 * exponent(random));
  const System system(sceneOf(net), {0});
  SolverOptions options;
  options.linear_solver = LinearSolver::kMultigrid;
  Workspace workspace(system.model);
  LinearSystem solver(workspace, options);
  Vectors x = Vectors::Zero(3, system.b.cols());
  const LinearSystem::Result first = solver.solve(system.matrix, system.b, 1e-8, x);
  EXPECT_TRUE(first.converged);
  EXPECT_EQ(first.factorizations, 1u);
  EXPECT_GT(first.iterations, 0u);
  // It remembers, and the next matrix does not pay for the attempt.
  x.setZero();
  const LinearSystem::Result second = solver.solve(system.matrix, system.b, 1e-8, x);
  EXPECT_TRUE(second.converged);
  EXPECT_EQ(second.factorizations, 1u);
  EXPECT_EQ(second.iterations, 0u);
}

}  // namespace
}  // namespace mass_spring
