// One whole step (forces, matrix, solve) of linear_implicit_euler: this library against plain
// Eigen, frame by frame in turn over the first second of the hanging cloth.
//
//   whole_step RESULTS.csv [N ...]
//
// All solve the same systems: Eigen's solvers start each frame from the state that the library's
// conjugate gradients start from. What the library returns is put into the equations that Eigen
// assembled; a residual above the tolerance ends the comparison as invalid. Processor time counts:
// it is the same on a machine that has other things to do.

#include <time.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "hanging_cloth.h"
#include "mass_spring_sim/simulation.h"
#include "plain_eigen.h"

namespace mass_spring {
namespace {

constexpr int kFrames = 60;
constexpr double kTolerance = 1e-6;
// The library's residual is computed with its own order of summation.
constexpr double kRounding = 1e-9;

struct Contender {
  std::string name;
  std::vector<double> processor, wall;  ///< ms, by frame
  double iterations = 0.0;              ///< per frame
  double worst_residual = 0.0;
};

Contender named(const std::string& name) {
  Contender contender;
  contender.name = name;
  return contender;
}

double processorMilliseconds() {
  timespec time;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

/// Adds the times of one frame.
template <typename Function>
void clockFrame(Contender& contender, Function&& function) {
  const double processor = processorMilliseconds();
  const auto start = std::chrono::steady_clock::now();
  function();
  const std::chrono::duration<double, std::milli> wall = std::chrono::steady_clock::now() - start;
  contender.wall.push_back(wall.count());
  contender.processor.push_back(processorMilliseconds() - processor);
}

double quantile(std::vector<double> values, double share) {
  const std::size_t rank = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[rank];
}

Simulation hangingSimulation(int n, LinearSolver solver) {
  Scene scene = hangingCloth(n);
  scene.solver.linear_solver = solver;
  scene.solver.linear_tolerance = kTolerance;
  scene.solver.max_linear_iterations = 100000;
  return Simulation(std::move(scene));
}

/// Steps the library, and checks its answer against the equations as Eigen has them.
void stepLibrary(Simulation& simulation, PlainEigen& referee, Contender& contender) {
  referee.assemble(simulation.state());
  StepReport report;
  clockFrame(contender, [&] { report = simulation.step(); });
  contender.iterations += static_cast<double>(report.linear_iterations) / kFrames;
  const double residual = referee.residual(simulation.state().velocities);
  contender.worst_residual = std::max(contender.worst_residual, residual);
  if (report.status != StepStatus::kConverged || !(residual <= kTolerance + kRounding)) {
    throw std::runtime_error(contender.name + ": relative residual " + std::to_string(residual) +
                             " in Eigen's equations; " + report.message);
  }
}

void stepEigen(const State& start, PlainEigen& eigen, Contender& contender) {
  State state = start;
  clockFrame(contender, [&] {
    eigen.assemble(state);
    eigen.solve(state);
  });
  contender.iterations += static_cast<double>(eigen.iterations()) / kFrames;
  contender.worst_residual = std::max(contender.worst_residual, eigen.residual(state.velocities));
}

std::vector<Contender> compare(int n) {
  Simulation iterative = hangingSimulation(n, LinearSolver::kConjugateGradient);
  Simulation direct = hangingSimulation(n, LinearSolver::kCholesky);
  Simulation automatic = hangingSimulation(n, LinearSolver::kAuto);
  const Eigen::Vector3d gravity = iterative.scene().effects.gravity->acceleration;
  const auto plain = [&](PlainEigen::Solver solver) {
    return PlainEigen(iterative.model(), gravity, iterative.pins().mask(), iterative.stepSize(),
                      solver, kTolerance);
  };
  PlainEigen conjugate_gradient = plain(PlainEigen::Solver::kConjugateGradient);
  PlainEigen ldlt = plain(PlainEigen::Solver::kSimplicialLdlt);
  PlainEigen referee = plain(PlainEigen::Solver::kSimplicialLdlt);

  std::vector<Contender> contenders = {named("Eigen ConjugateGradient"),
                                       named("Eigen SimplicialLDLT"), named("ours, auto"),
                                       named("ours, conjugate_gradient"), named("ours, cholesky")};
  for (int frame = 0; frame < kFrames; ++frame) {
    const State start = iterative.state();
    stepEigen(start, conjugate_gradient, contenders[0]);
    stepEigen(start, ldlt, contenders[1]);
    stepLibrary(automatic, referee, contenders[2]);
    stepLibrary(iterative, referee, contenders[3]);
    stepLibrary(direct, referee, contenders[4]);
  }
  return contenders;
}

void run(const std::string& path, const std::vector<int>& resolutions) {
  std::ofstream csv(path);
  csv << "n,contender,frame,processor_ms,wall_ms\n";
  std::puts(
      "| N | whole step by | ms, median | ms, p90 | wall ms, median | iterations/frame | "
      "worst residual | Eigen CG / this |");
  std::puts("|---|---|---|---|---|---|---|---|");
  for (const int n : resolutions) {
    std::fflush(stdout);
    const std::vector<Contender> contenders = compare(n);
    const double baseline = quantile(contenders[0].processor, 0.5);
    for (const Contender& c : contenders) {
      const double median = quantile(c.processor, 0.5);
      std::printf("| %d | %s | %.3g | %.3g | %.3g | %.0f | %.1e | %.2f |\n", n, c.name.c_str(),
                  median, quantile(c.processor, 0.9), quantile(c.wall, 0.5), c.iterations,
                  c.worst_residual, baseline / median);
      for (int frame = 0; frame < kFrames; ++frame) {
        csv << n << ",\"" << c.name << "\"," << frame << ',' << c.processor[frame] << ','
            << c.wall[frame] << '\n';
      }
    }
  }
  if (!csv.flush()) throw std::runtime_error("cannot write " + path);
}

}  // namespace
}  // namespace mass_spring

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fputs("usage: whole_step RESULTS.csv [N ...]\n", stderr);
    return 1;
  }
  std::vector<int> resolutions;
  for (int i = 2; i < argc; ++i) resolutions.push_back(std::atoi(argv[i]));
  if (resolutions.empty()) resolutions = {20, 50, 100};
  try {
    mass_spring::run(argv[1], resolutions);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "whole_step: %s\n", error.what());
    return 1;
  }
  return 0;
}
