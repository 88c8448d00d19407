// The parts of a linearly implicit step, each by itself, on the hanging cloth after half a second,
// when it swings and many of its springs are compressed. The argument of each is N.

#include <benchmark/benchmark.h>

#include <Eigen/SparseCore>
#include <memory>

#include "effects/effect.h"
#include "hanging_cloth.h"
#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/simulation.h"
#include "plain_eigen.h"
#include "solvers/conjugate_gradient.h"
#include "solvers/incomplete_cholesky.h"
#include "solvers/sparse_cholesky.h"
#include "solvers/step_matrix.h"

namespace mass_spring {
namespace {

constexpr int kFrames = 30;
constexpr double kStep = 1.0 / 60.0;  // s
const MatrixWeights kWeights{1.0, kStep, kStep* kStep};

/// A cloth in motion, and its step matrix.
struct Swing {
  explicit Swing(int n) : simulation(hangingCloth(n)) {
    for (int frame = 0; frame < kFrames; ++frame) simulation.step();
    PatternBuilder builder;
    for (const auto& effect : effects()) effect->addPattern(builder);
    pattern = std::make_shared<BlockPattern>(simulation.model().particleCount(), builder);
    for (const auto& effect : effects()) effect->findSlots(*pattern);
    matrix = std::make_unique<StepMatrix>(pattern);
    assemble();
    right_side = simulation.state().velocities * simulation.model().masses.asDiagonal();
  }

  const std::vector<std::unique_ptr<Effect>>& effects() const { return simulation.model().effects; }
  const State& state() const { return simulation.state(); }
  void assemble() {
    matrix->setMasses(kWeights.mass, simulation.model().masses);
    for (const auto& effect : effects()) {
      effect->addDerivatives(state().positions, kWeights, Projection::kWhereNeeded, *matrix);
    }
    matrix->decouple(simulation.pins().mask());
  }

  Simulation simulation;
  std::shared_ptr<const BlockPattern> pattern;
  std::unique_ptr<StepMatrix> matrix;
  Vectors right_side;
};

void forces(benchmark::State& run) {
  const Swing swing(static_cast<int>(run.range(0)));
  Vectors sum(3, swing.state().positions.cols());
  for (auto _ : run) {
    sum.setZero();
    for (const auto& effect : swing.effects()) {
      effect->addForces(swing.state().positions, swing.state().velocities, sum);
    }
    benchmark::DoNotOptimize(sum.data());
  }
  run.SetItemsProcessed(run.iterations() * swing.simulation.model().springs.size());
}

void assembly(benchmark::State& run) {
  Swing swing(static_cast<int>(run.range(0)));
  for (auto _ : run) {
    swing.assemble();
    benchmark::DoNotOptimize(swing.matrix.get());
  }
  run.SetItemsProcessed(run.iterations() * swing.simulation.model().springs.size());
}

void product(benchmark::State& run) {
  const Swing swing(static_cast<int>(run.range(0)));
  Vectors y(3, swing.right_side.cols());
  for (auto _ : run) {
    swing.matrix->multiply(swing.right_side, y);
    benchmark::DoNotOptimize(y.data());
  }
  run.counters["nonzeros"] = static_cast<double>(swing.pattern->nonzeros());
}

void incompleteFactor(benchmark::State& run) {
  const Swing swing(static_cast<int>(run.range(0)));
  IncompleteCholesky preconditioner(swing.pattern);
  for (auto _ : run) benchmark::DoNotOptimize(preconditioner.factorize(*swing.matrix));
}

void incompleteApply(benchmark::State& run) {
  const Swing swing(static_cast<int>(run.range(0)));
  IncompleteCholesky preconditioner(swing.pattern);
  preconditioner.factorize(*swing.matrix);
  Vectors z(3, swing.right_side.cols());
  for (auto _ : run) {
    preconditioner.apply(swing.right_side, z);
    benchmark::DoNotOptimize(z.data());
  }
}

void conjugateGradientSolve(benchmark::State& run) {
  const Swing swing(static_cast<int>(run.range(0)));
  ConjugateGradient solver(swing.pattern);
  Vectors x(3, swing.right_side.cols());
  LinearResult result;
  for (auto _ : run) {
    x.setZero();
    result = solver.solve(*swing.matrix, swing.right_side, 1e-6, 100000, x);
    benchmark::DoNotOptimize(x.data());
  }
  run.counters["iterations"] = result.iterations;
}

void choleskyFactor(benchmark::State& run) {
  const Swing swing(static_cast<int>(run.range(0)));
  SparseCholesky solver(swing.pattern);
  for (auto _ : run) benchmark::DoNotOptimize(solver.factorize(*swing.matrix));
  run.counters["block_products"] = static_cast<double>(solver.blockProducts());
}

void choleskySolve(benchmark::State& run) {
  const Swing swing(static_cast<int>(run.range(0)));
  SparseCholesky solver(swing.pattern);
  solver.factorize(*swing.matrix);
  Vectors x(3, swing.right_side.cols());
  for (auto _ : run) {
    solver.solve(swing.right_side, x);
    benchmark::DoNotOptimize(x.data());
  }
}

PlainEigen plainEigen(const Simulation& simulation) {
  return PlainEigen(simulation.model(), simulation.scene().effects.gravity->acceleration,
                    simulation.pins().mask(), kStep, PlainEigen::Solver::kConjugateGradient, 1e-6);
}

void eigenForcesAndAssembly(benchmark::State& run) {
  const Swing swing(static_cast<int>(run.range(0)));
  PlainEigen eigen = plainEigen(swing.simulation);
  for (auto _ : run) {
    eigen.assemble(swing.state());
    benchmark::DoNotOptimize(eigen.matrix().valuePtr());
  }
}

void eigenProduct(benchmark::State& run) {
  const Swing swing(static_cast<int>(run.range(0)));
  PlainEigen eigen = plainEigen(swing.simulation);
  eigen.assemble(swing.state());
  const Eigen::VectorXd x = Eigen::VectorXd::Ones(eigen.matrix().cols());
  Eigen::VectorXd y(x.size());
  for (auto _ : run) {
    y.noalias() = eigen.matrix() * x;
    benchmark::DoNotOptimize(y.data());
  }
}

void measures(benchmark::State& run) {
  const Swing swing(static_cast<int>(run.range(0)));
  const Model& model = swing.simulation.model();
  for (auto _ : run) {
    benchmark::DoNotOptimize(energy(model, swing.state()).total());
    benchmark::DoNotOptimize(maxStretch(model, swing.state()));
  }
}

#define ALL_SIZES Arg(20)->Arg(50)->Arg(100)->Unit(benchmark::kMicrosecond)
BENCHMARK(forces)->ALL_SIZES;
BENCHMARK(assembly)->ALL_SIZES;
BENCHMARK(eigenForcesAndAssembly)->ALL_SIZES;
BENCHMARK(product)->ALL_SIZES;
BENCHMARK(eigenProduct)->ALL_SIZES;
BENCHMARK(incompleteFactor)->ALL_SIZES;
BENCHMARK(incompleteApply)->ALL_SIZES;
BENCHMARK(conjugateGradientSolve)->ALL_SIZES;
BENCHMARK(choleskyFactor)->ALL_SIZES;
BENCHMARK(choleskySolve)->ALL_SIZES;
BENCHMARK(measures)->ALL_SIZES;

}  // namespace
}  // namespace mass_spring

BENCHMARK_MAIN();
