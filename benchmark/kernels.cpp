// The parts of a linearly implicit step, each by itself, on the hanging cloth after half a second,
// when it swings and many of its springs are compressed. The argument of each is N.

#include <benchmark/benchmark.h>

#include <Eigen/SparseCore>
#include <memory>

#include "effects/effect.h"
#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/simulation.h"
#include "plain_eigen.h"
#include "scenes.h"
#include "solvers/linear_system.h"
#include "solvers/step_matrix.h"

namespace mass_spring {
namespace {

constexpr int kFrames = 30;
constexpr double kStep = 1.0 / 60.0;  // s
const MatrixWeights kWeights{1.0, kStep, kStep* kStep};

/// A cloth in motion, and its step matrix.
struct Swing {
  explicit Swing(int n)
      : simulation(hangingCloth(n)),
        pattern(simulation.model().pattern),
        workspace(simulation.model()) {
    for (int frame = 0; frame < kFrames; ++frame) simulation.step();
    matrix = std::make_unique<StepMatrix>(pattern);
    assemble();
    right_side = simulation.state().velocities * simulation.model().masses.asDiagonal();
  }

  const State& state() const { return simulation.state(); }
  Point point() const {
    return {state().positions, state().velocities, state().time, state().effects};
  }
  void assemble() {
    matrix->setMasses(kWeights.mass, simulation.model().masses);
    for (const Workspace::Part& part : workspace.parts()) {
      part.effect->addDerivatives(point(), part.scratch.get(), kWeights, Projection::kWhereNeeded,
                                  *matrix);
    }
    matrix->decouple(simulation.pins().mask());
  }

  Simulation simulation;
  std::shared_ptr<const BlockPattern> pattern;
  Workspace workspace;
  std::unique_ptr<StepMatrix> matrix;
  Vectors right_side;
};

/// Seconds per spring and evaluation.
void countSprings(benchmark::State& run, const Swing& swing) {
  using benchmark::Counter;
  run.counters["per_spring"] = Counter(static_cast<double>(swing.simulation.model().springs.size()),
                                       Counter::kIsIterationInvariantRate | Counter::kInvert);
}

/// All effects: springs, their damping, gravity.
void forces(benchmark::State& run) {
  Swing swing(static_cast<int>(run.range(0)));
  Vectors sum(3, swing.state().positions.cols());
  for (auto _ : run) {
    sumForces(swing.workspace, nullptr, swing.point(), sum);
    benchmark::DoNotOptimize(sum.data());
  }
  countSprings(run, swing);
}

/// Springs and their damping as one writes them down, spring by spring.
void plainForces(benchmark::State& run) {
  const Swing swing(static_cast<int>(run.range(0)));
  const std::vector<Spring>& springs = swing.simulation.model().springs;
  const Vectors &x = swing.state().positions, &v = swing.state().velocities;
  Vectors sum(3, x.cols());
  for (auto _ : run) {
    sum.setZero();
    for (const Spring& s : springs) {
      const Eigen::Vector3d d = x.col(s.j) - x.col(s.i);
      const double length = d.norm();
      const Eigen::Vector3d n = d / length;
      const double rate = (v.col(s.j) - v.col(s.i)).dot(n);
      const Eigen::Vector3d f = (s.stiffness * (length - s.rest_length) + s.damping * rate) * n;
      sum.col(s.i) += f;
      sum.col(s.j) -= f;
    }
    benchmark::DoNotOptimize(sum.data());
  }
  countSprings(run, swing);
}

/// Forces, energy and dissipation at one point, as Newton's line search needs them.
void forcesAndEnergies(benchmark::State& run) {
  Swing swing(static_cast<int>(run.range(0)));
  Vectors sum(3, swing.state().positions.cols());
  for (auto _ : run) {
    Energy energy;
    double dissipation = 0.0;
    sumForces(swing.workspace, nullptr, swing.point(), {&sum, &energy, &dissipation, nullptr});
    benchmark::DoNotOptimize(energy.elastic + dissipation);
  }
  countSprings(run, swing);
}

void assembly(benchmark::State& run) {
  Swing swing(static_cast<int>(run.range(0)));
  for (auto _ : run) {
    swing.assemble();
    benchmark::DoNotOptimize(swing.matrix.get());
  }
  countSprings(run, swing);
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

/// A factor or preconditioner and a solution from nothing to 1e-6.
void linearSolve(benchmark::State& run, LinearSolver solver) {
  const Swing swing(static_cast<int>(run.range(0)));
  SolverOptions options;
  options.linear_solver = solver;
  options.threads = 1;
  Workspace workspace(swing.simulation.model());
  LinearSystem system(workspace, options);
  Vectors x(3, swing.right_side.cols());
  LinearSystem::Result result;
  for (auto _ : run) {
    x.setZero();
    result = system.solve(*swing.matrix, swing.right_side, 1e-6, x);
    benchmark::DoNotOptimize(x.data());
  }
  run.counters["iterations"] = result.iterations;
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
    benchmark::DoNotOptimize(swing.simulation.energy().total());
    benchmark::DoNotOptimize(maxStretch(model, swing.state()));
  }
}

#define ALL_SIZES Arg(20)->Arg(50)->Arg(100)->Arg(200)->Unit(benchmark::kMicrosecond)
BENCHMARK(forces)->ALL_SIZES;
BENCHMARK(plainForces)->ALL_SIZES;
BENCHMARK(forcesAndEnergies)->ALL_SIZES;
BENCHMARK(assembly)->ALL_SIZES;
BENCHMARK(eigenForcesAndAssembly)->ALL_SIZES;
BENCHMARK(product)->ALL_SIZES;
BENCHMARK(eigenProduct)->ALL_SIZES;
BENCHMARK_CAPTURE(linearSolve, conjugate_gradient, LinearSolver::kConjugateGradient)->ALL_SIZES;
BENCHMARK_CAPTURE(linearSolve, multigrid, LinearSolver::kMultigrid)->ALL_SIZES;
BENCHMARK_CAPTURE(linearSolve, cholesky, LinearSolver::kCholesky)->ALL_SIZES;
BENCHMARK(measures)->ALL_SIZES;

}  // namespace
}  // namespace mass_spring

BENCHMARK_MAIN();
