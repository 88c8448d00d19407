// What solver.accuracy and solver.budget keep of what they promise, on scenes of many kinds.
//
//   error_control [--quick] [NAME]   only scenes whose name contains NAME; --quick: every fifth

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <string>
#include <vector>

#include "contender.h"
#include "mass_spring_sim/simulation.h"
#include "reference.h"
#include "scheme_choice.h"
#include "varied_scenes.h"

namespace mass_spring {
namespace {

constexpr double kAccuracy = 1e-3;            // m, asked for
constexpr double kPromise = 2.0 * kAccuracy;  // m, RMS at the end
constexpr double kMostCost = 3.0;  // times the cheapest fixed setting that keeps the promise
constexpr double kBudget = 5e-3;   // s
constexpr int kMostSubsteps = 1 << 14;

struct Run {
  Scheme scheme = Scheme::kAuto;
  int substeps = 0;      // per frame; of a controlled run their mean
  double error = 0.0;    // m, RMS at the end
  double seconds = 0.0;  // of the processor
  StepTotals totals;
  bool good() const { return error <= kPromise; }
};

/// s of the calling thread.
double processorTime() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Steps to the last frame of the reference, or until it takes longer than `patience` [s].
/// Short runs are repeated, and the fastest counts.
Run run(const Scene& scene, const Reference& reference, double patience) {
  Run best;
  double spent = 0.0;
  for (int repeat = 0; repeat < 5; ++repeat) {
    Simulation simulation(scene);
    Run one;
    one.scheme = simulation.model().solver.scheme;
    const double start = processorTime();
    bool failed = false;
    for (std::size_t n = 0; n < reference.frames.size() && !failed; ++n) {
      failed =
          simulation.step().status == StepStatus::kFailed || processorTime() - start > patience;
    }
    one.seconds = processorTime() - start;
    one.totals = simulation.totals();
    one.substeps =
        static_cast<int>(one.totals.substeps / std::max<std::uint64_t>(one.totals.steps, 1));
    one.error = failed ? INFINITY
                       : reference.distance(simulation.state().positions, reference.frames.back());
    if (repeat == 0 || one.seconds < best.seconds) best = one;
    spent += one.seconds;
    if (failed || spent > 0.3) break;
  }
  return best;
}

bool own = true;

/// The cheapest number of sub-steps, among the powers of 2, that keeps the promise.
Run cheapestFixed(Scene scene, Scheme scheme, const Reference& reference, double patience) {
  scene.solver.scheme = scheme;
  scene.solver.accuracy.reset();
  int substeps = 1;
  if (!info(scheme).implicit) {
    const SpectrumBounds bounds = boundSpectrum(buildModel(scene));
    const double stable =
        scheme == Scheme::kRk4 ? stableRk4Step(bounds) : stableSymplecticStep(bounds);
    // The bound is safe: half of it may do as well.
    while (substeps * stable * scene.rate < 0.5) substeps *= 2;
  }
  Run best;
  best.error = INFINITY;
  best.seconds = INFINITY;
  for (; substeps <= kMostSubsteps; substeps *= 2) {
    scene.solver.substeps = substeps;
    Run one = run(scene, reference, best.good() ? 3.0 * patience : patience);
    one.substeps = substeps;
    // Twice as many must keep it too: a setting that does so by chance is none to choose.
    if (one.good() && best.good()) return best;
    best = one;
    if (!one.good() && one.seconds > patience) break;
  }
  best.seconds = INFINITY;
  return best;
}

std::string describe(const Run& run) {
  if (!std::isfinite(run.seconds)) return "-";
  char text[100];
  std::snprintf(text, sizeof text, "%s x %d, %.2f mm, %.3g ms [%.2g]", name(run.scheme).c_str(),
                run.substeps, 1e3 * run.error, 1e3 * run.seconds, 1e3 * run.totals.estimated_error);
  return text;
}

struct Tally {
  int runs = 0, good = 0, cheap = 0;
  std::vector<double> ratios;
  void add(const Run& run, const Run& fixed) {
    ++runs;
    good += run.good();
    const double ratio = run.seconds / fixed.seconds;
    cheap += ratio <= kMostCost;
    ratios.push_back(ratio);
  }
  void print(const char* what) const {
    if (runs == 0) return;
    std::printf(
        "%s: within %.0f mm in %d of %d (%.0f %%); at most %.0f times the cost in %d (%.0f %%), "
        "median %.2f, largest %.2f\n",
        what, 1e3 * kPromise, good, runs, 100.0 * good / runs, kMostCost, cheap,
        100.0 * cheap / runs, quantile(ratios, 0.5), quantile(ratios, 1.0));
  }
};

void studyAccuracy(const std::vector<VariedScene>& scenes) {
  std::printf("| scene | horizon, s | reference +- mm | ");
  std::puts(
      "`auto` | cheapest of all | times | `tr_bdf2` | its cheapest | times | `ros3` | its cheapest "
      "| times |");
  std::puts("|---|---|---|---|---|---|---|---|---|---|---|---|");
  Tally automatic, tr_bdf2, ros3;
  for (const VariedScene& varied : scenes) {
    const Reference reference = findReference(varied.scene, varied.duration, 0.1 * kAccuracy);
    std::printf("| %s | %s%.2f | %.1e |", varied.name.c_str(), reference.whole ? "> " : "",
                static_cast<double>(reference.frames.size()) / varied.scene.rate,
                1e3 * reference.difference);
    const auto controlled = [&](Scheme scheme) {
      Scene scene = varied.scene;
      scene.solver.scheme = scheme;
      scene.solver.accuracy = kAccuracy;
      return run(scene, reference, 60.0);
    };
    Run by_auto = controlled(Scheme::kAuto), by_tr, by_ros;
    if (own) {
      by_tr = controlled(Scheme::kTrBdf2);
      by_ros = controlled(Scheme::kRos3);
    }
    const double patience = 20.0 * std::max(0.02, by_auto.seconds);
    Run cheapest, fixed_tr, fixed_ros;
    cheapest.seconds = INFINITY;
    for (const Scheme scheme :
         {Scheme::kRk4, Scheme::kSymplecticEuler, Scheme::kTrBdf2, Scheme::kRos3, Scheme::kBdf2,
          Scheme::kImplicitMidpoint, Scheme::kLinearImplicitEuler}) {
      const bool is_own = own && (scheme == Scheme::kTrBdf2 || scheme == Scheme::kRos3);
      const Run fixed =
          cheapestFixed(varied.scene, scheme, reference,
                        is_own ? patience : std::min(patience, 1.5 * cheapest.seconds));
      if (scheme == Scheme::kTrBdf2) fixed_tr = fixed;
      if (scheme == Scheme::kRos3) fixed_ros = fixed;
      if (fixed.seconds < cheapest.seconds) cheapest = fixed;
    }
    for (const auto& [by, fixed, tally] :
         {std::tuple(&by_auto, &cheapest, &automatic), std::tuple(&by_tr, &fixed_tr, &tr_bdf2),
          std::tuple(&by_ros, &fixed_ros, &ros3)}) {
      if (by->totals.steps == 0) continue;
      tally->add(*by, *fixed);
      std::printf(" %s%s | %s | %.2f |", describe(*by).c_str(), by->good() ? "" : " **missed**",
                  describe(*fixed).c_str(), by->seconds / fixed->seconds);
    }
    std::puts("");
    std::fflush(stdout);
  }
  automatic.print("\n`auto`, against all fixed settings");
  tr_bdf2.print("`tr_bdf2`, against itself in fixed sub-steps");
  ros3.print("`ros3`, against itself in fixed sub-steps");
}

void studyBudget(const std::vector<VariedScene>& scenes) {
  std::puts(
      "\n| scene | 1 sub-step, ms | median, ms | p99, ms | largest, ms | sub-steps | "
      "estimated error bought, mm/step | with 1 sub-step | cheaper scheme | degraded |");
  std::puts("|---|---|---|---|---|---|---|---|---|---|");
  int runs = 0, kept = 0;
  for (const VariedScene& varied : scenes) {
    using Clock = std::chrono::steady_clock;
    const int frames = 300;
    const auto measure = [&](Scene scene, std::vector<double>& ms, int& degraded, int& cheaper) {
      Simulation simulation(scene);
      StepTotals totals;
      for (int n = 0; n < frames; ++n) {
        const Clock::time_point start = Clock::now();
        const StepReport report = simulation.step();
        ms.push_back(1e3 * std::chrono::duration<double>(Clock::now() - start).count());
        degraded += report.status != StepStatus::kConverged;
        cheaper += report.scheme != simulation.model().solver.scheme;
      }
      return simulation.totals();
    };
    std::vector<double> one_ms, cheap_ms, ms;
    int degraded = 0, cheaper = 0, ignored = 0;
    Scene scene = varied.scene;
    scene.solver.scheme = Scheme::kLinearImplicitEuler;
    measure(scene, cheap_ms, ignored, ignored);
    if (quantile(cheap_ms, 0.99) > 1e3 * kBudget) continue;
    scene.solver.scheme = Scheme::kTrBdf2;
    const StepTotals one = measure(scene, one_ms, ignored, ignored);
    scene.solver.budget = kBudget;
    const StepTotals totals = measure(scene, ms, degraded, cheaper);
    ++runs;
    kept += quantile(ms, 0.99) <= 1.1e3 * kBudget;
    std::printf("| %s | %.2f | %.2f | %.2f | %.2f | %.1f | %.2g | %.2g | %d | %d |\n",
                varied.name.c_str(), quantile(one_ms, 0.5), quantile(ms, 0.5), quantile(ms, 0.99),
                quantile(ms, 1.0), static_cast<double>(totals.substeps) / frames,
                1e3 * totals.estimated_error / frames, 1e3 * one.estimated_error / frames, cheaper,
                degraded);
    std::fflush(stdout);
  }
  std::printf("\n99th percentile below %.1f ms in %d of %d\n", 1.1e3 * kBudget, kept, runs);
}

}  // namespace
}  // namespace mass_spring

int main(int argc, char** argv) {
  using namespace mass_spring;
  const std::vector<VariedScene> all = variedScenes();
  std::vector<VariedScene> scenes;
  std::string part;
  bool quick = false, budget = true, accuracy = true;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--quick") == 0)
      quick = true;
    else if (std::strcmp(argv[i], "--accuracy") == 0)
      budget = false;
    else if (std::strcmp(argv[i], "--auto") == 0)
      own = budget = false;
    else if (std::strcmp(argv[i], "--budget") == 0)
      accuracy = false;
    else
      part = argv[i];
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    if ((quick && i % 5 != 0) || all[i].name.find(part) == std::string::npos) continue;
    scenes.push_back(all[i]);
  }
  if (accuracy) studyAccuracy(scenes);
  if (budget) studyBudget(scenes);
  return 0;
}
