// One whole step (forces, matrix, solve) of linear_implicit_euler: this library, with each of its
// linear solvers, against plain Eigen and CHOLMOD, frame by frame in turn over the first second of
// each scene.
//
//   whole_step RESULTS.csv [--frames N] [--seconds S] [SCENE ...]     SCENE: 50, lattice, rope ...
//
// All solve the same systems: every contender starts each frame from the state that `auto` with one
// thread has reached. What each returns is put into the equations as Eigen assembles them; a
// residual above the tolerance, beyond rounding, ends the comparison as invalid. Frames that the
// library redoes in parts, since the step gained energy, are left out. Slow contenders take part in
// fewer frames, evenly spread; ratios compare the frames that both took part in.

#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <list>
#include <memory>
#include <stdexcept>

#include "contender.h"
#include "mass_spring_sim/simulation.h"
#include "plain_eigen.h"
#include "scenes.h"
#include "stepper.h"

namespace mass_spring {
namespace {

constexpr double kTolerance = 1e-6;
// The library multiplies by the matrix in its own order of summation.
constexpr double kRounding = 1e-9;

struct Options {
  std::string path;
  int frames = 60;        ///< per scene
  double seconds = 30.0;  ///< per contender and scene
  std::vector<std::string> scenes;
};

Scene sceneNamed(const std::string& name) {
  if (name == "lattice") return hangingLattice(20);
  if (name == "rope") return swingingRope(10000);
  const int n = std::atoi(name.c_str());
  if (n < 2) throw std::invalid_argument("no scene " + name);
  return hangingCloth(n);
}

/// Its memory is all that a stepper holds: matrix, solver, the scheme's vectors.
Contender libraryContender(const Simulation& scene, LinearSolver solver, int threads) {
  Scene own = scene.scene();
  own.solver.linear_solver = solver;
  own.solver.linear_tolerance = kTolerance;
  own.solver.max_linear_iterations = 100000;
  own.solver.threads = threads;
  Contender contender;
  contender.name = "this, " + name(solver);
  if (threads > 1) contender.name += ", " + std::to_string(threads) + " threads";
  const auto model = std::make_shared<Model>(buildModel(own));
  const std::size_t heap = heapBytes();
  const auto stepper = std::make_shared<Stepper>(*model, own.solver);
  contender.bytes = heapBytes() - heap;
  const std::string title = contender.name;
  contender.step = [&scene, model, stepper, title](State& state) {
    const StepReport report = stepper->step(scene.stepSize(), scene.pins(), nullptr, state);
    if (report.status == StepStatus::kFailed)
      throw std::runtime_error(title + ": " + report.message);
    // A step that was redone in parts, as it gained energy, solved other equations than Eigen does.
    return StepOutcome{report.linear_iterations, report.status == StepStatus::kConverged};
  };
  return contender;
}

std::shared_ptr<PlainEigen> plainEigen(const Simulation& scene, PlainEigen::Solver solver) {
  return std::make_shared<PlainEigen>(scene.model(), scene.scene().effects.gravity->acceleration,
                                      scene.pins().mask(), scene.stepSize(), solver, kTolerance);
}

/// Its memory is what the solver takes; triplets and matrix are not counted.
Contender eigenContender(const std::string& name, const Simulation& scene,
                         PlainEigen::Solver solver) {
  Contender contender;
  contender.name = name;
  const auto eigen = plainEigen(scene, solver);
  contender.prepare = [eigen](const State& state) {
    if (eigen->matrix().nonZeros() == 0) eigen->assemble(state);
  };
  contender.step = [eigen](State& state) {
    eigen->assemble(state);
    eigen->solve(state);
    return StepOutcome{static_cast<std::uint32_t>(eigen->iterations()), true};
  };
  return contender;
}

/// `auto` with one thread comes first: it leads.
std::list<Contender> contendersFor(const Simulation& scene) {
  std::list<Contender> all;
  all.push_back(libraryContender(scene, LinearSolver::kAuto, 1));
  all.push_back(libraryContender(scene, LinearSolver::kAuto, 2));
  for (const std::string& solver : linearSolverNames()) {
    if (solver == "auto") continue;
    all.push_back(libraryContender(scene, *linearSolverFromName(solver), 1));
  }
  using Solver = PlainEigen::Solver;
  all.push_back(eigenContender("Eigen ConjugateGradient", scene, Solver::kConjugateGradient));
  all.push_back(eigenContender("Eigen SimplicialLDLT", scene, Solver::kSimplicialLdlt));
  all.push_back(eigenContender("CHOLMOD", scene, Solver::kCholmod));
  return all;
}

std::list<Contender> compare(const Simulation& scene, const Options& options) {
  std::list<Contender> contenders = contendersFor(scene);
  const auto referee = plainEigen(scene, PlainEigen::Solver::kSimplicialLdlt);
  State state = scene.model().start;
  for (int frame = 0; frame < options.frames; ++frame) {
    referee->assemble(state);
    State next;
    for (Contender& contender : contenders) {
      const bool leads = &contender == &contenders.front();
      if (!leads && !hasTime(contender, options.seconds, frame, options.frames)) continue;
      bool comparable = true;
      State reached = clockStep(contender, state, frame, comparable);
      if (comparable) {
        const double residual = referee->residual(reached.velocities);
        contender.worst_residual = std::max(contender.worst_residual, residual);
        // Eigen's own conjugate gradients may drift from the true residual: theirs is only told.
        if (contender.name.rfind("this", 0) == 0 &&
            !(residual <= kTolerance + kRounding + referee->rounding())) {
          throw std::runtime_error(contender.name + ": relative residual " +
                                   std::to_string(residual) + " in Eigen's equations");
        }
      }
      if (leads) next = std::move(reached);
      if (leads && !comparable) break;
    }
    state = std::move(next);
  }
  return contenders;
}

void printTable(const std::string& scene, const std::list<Contender>& contenders) {
  for (const Contender& c : contenders) {
    std::vector<double> wall, processor;
    for (const Contender::Sample& sample : c.samples) {
      wall.push_back(sample.wall);
      processor.push_back(sample.processor);
    }
    const auto count = static_cast<double>(c.samples.size());
    std::printf("| %s | %s | %.3g | %.3g | %.3g | %.1f | %.1e | %.1f | %.2f | %zu |\n",
                scene.c_str(), c.name.c_str(), quantile(wall, 0.5), quantile(wall, 0.9),
                quantile(processor, 0.5), c.iterations / count, c.worst_residual,
                1e-6 * static_cast<double>(c.bytes), medianRatio(c, contenders.front()),
                c.samples.size());
  }
  std::fflush(stdout);
}

/// By what power of the side N of a cloth iterations and time grow from one size to the next.
void printGrowth(const std::vector<std::pair<int, std::list<Contender>>>& cloths) {
  std::puts("\n| from N to N | step by | iterations grow as | time grows as |\n|---|---|---|---|");
  for (std::size_t k = 1; k < cloths.size(); ++k) {
    const auto& [small, before] = cloths[k - 1];
    const auto& [large, after] = cloths[k];
    auto b = before.begin();
    for (auto a = after.begin(); a != after.end(); ++a, ++b) {
      const double doublings = std::log(static_cast<double>(large) / small);
      const auto mean = [](const Contender& c) {
        return c.iterations / static_cast<double>(c.samples.size());
      };
      std::printf("| %d to %d | %s | ", small, large, a->name.c_str());
      if (mean(*a) > 0.0 && mean(*b) > 0.0) {
        std::printf("N^%.2f", std::log(mean(*a) / mean(*b)) / doublings);
      }
      std::printf(" | N^%.2f |\n", std::log(medianWall(*a) / medianWall(*b)) / doublings);
    }
  }
}

void run(const Options& options) {
  std::ofstream csv(options.path);
  csv << "scene,contender,frame,wall_ms,processor_ms\n";
  std::puts(
      "| scene | whole step by | ms, median | ms, p90 | processor ms, median | iterations/frame | "
      "worst residual | MB | times `auto` | frames |\n|---|---|---|---|---|---|---|---|---|---|");
  std::vector<std::pair<int, std::list<Contender>>> cloths;
  for (const std::string& name : options.scenes) {
    std::fflush(stdout);
    const Simulation scene(sceneNamed(name));
    std::list<Contender> contenders = compare(scene, options);
    printTable(name, contenders);
    for (Contender& c : contenders) {
      for (const Contender::Sample& sample : c.samples) {
        csv << name << ",\"" << c.name << "\"," << sample.frame << ',' << sample.wall << ','
            << sample.processor << '\n';
      }
      c.step = nullptr;  // what it holds refers to the scene
      c.prepare = nullptr;
    }
    if (std::atoi(name.c_str()) > 0) cloths.emplace_back(std::atoi(name.c_str()), contenders);
  }
  printGrowth(cloths);
  if (!csv.flush()) throw std::runtime_error("cannot write " + options.path);
}

/// @throws std::invalid_argument
Options parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--frames" || word == "--seconds") {
      if (++i == argc) throw std::invalid_argument(word + " needs a number");
      (word == "--frames" ? options.frames = std::atoi(argv[i])
                          : options.seconds = std::atof(argv[i]));
    } else if (options.path.empty()) {
      options.path = word;
    } else {
      options.scenes.push_back(word);
    }
  }
  if (options.path.empty() || options.frames < 1) {
    throw std::invalid_argument(
        "usage: whole_step RESULTS.csv [--frames N] [--seconds S] [SCENE ...]");
  }
  if (options.scenes.empty()) options.scenes = {"20", "50", "100", "200", "lattice", "rope"};
  return options;
}

}  // namespace
}  // namespace mass_spring

int main(int argc, char** argv) {
  // CHOLMOD is faster here if neither it nor its BLAS makes threads, which they decide on when they
  // are loaded.
  if (!std::getenv("OMP_THREAD_LIMIT") || !std::getenv("OPENBLAS_NUM_THREADS")) {
    setenv("OMP_THREAD_LIMIT", "1", 1);
    setenv("OPENBLAS_NUM_THREADS", "1", 1);
    execv("/proc/self/exe", argv);
  }
  try {
    mass_spring::run(mass_spring::parse(argc, argv));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "whole_step: %s\n", error.what());
    return 1;
  }
  return 0;
}
