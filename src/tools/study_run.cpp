#include "tools/study_run.h"

#include <algorithm>
#include <cmath>

#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/simulation.h"
#include "tools/step_times.h"
#include "tools/study_report.h"
#include "tools/wall_clock.h"

namespace mass_spring {
namespace {

constexpr double kExploded = 10.0;  // extents of the scene, of an error
constexpr double kLong = 2.0;       // s: runs that are not repeated, nor one that was interrupted

Scene sceneWith(const Study& study, const StudySetting& setting) {
  Scene scene = study.scene;
  scene.rate = setting.rate;
  scene.solver.scheme = setting.scheme;
  scene.solver.substeps = std::max(setting.substeps, 1);
  if (setting.newton_tolerance) scene.solver.newton_tolerance = *setting.newton_tolerance;
  scene.solver.accuracy = setting.accuracy;
  scene.solver.calibration.clear();
  scene.solver.budget.reset();
  return scene;
}

/// The sums of squares and the largest values over frames.
struct Errors {
  double square = 0.0, largest = 0.0, energy = 0.0, momentum = 0.0;
  std::size_t terms = 0;

  void add(const Reference& reference, const Model& model, const State& state, const State& truth) {
    for (Eigen::Index i = 0; i < state.positions.cols(); ++i) {
      if (reference.pinned[static_cast<std::size_t>(i)]) continue;
      const double error = (state.positions.col(i) - truth.positions.col(i)).squaredNorm();
      square += error;
      largest = std::max(largest, std::sqrt(error));
      ++terms;
    }
    energy = std::max(energy, std::abs(mass_spring::energy(model, state).total() -
                                       mass_spring::energy(model, truth).total()));
    momentum = std::max(
        momentum,
        (mass_spring::momentum(model, state) - mass_spring::momentum(model, truth)).norm());
  }
};

/// One run; its time is that of the steps alone.
StudyRow runOnce(const Study& study, const StudySetting& setting, double patience) {
  StudyRow row;
  row.setting = setting;
  Simulation simulation(sceneWith(study, setting));
  const auto steps_per_frame =
      static_cast<std::uint64_t>(std::lround(setting.rate / study.frame_rate));
  Errors errors;
  std::vector<std::vector<double>> amplitudes(study.modes.modes.size());
  StepTimes times;
  StepStatus worst = StepStatus::kConverged;
  bool whole = true;
  for (std::size_t frame = 0; whole && frame < study.reference.frames.size(); ++frame) {
    for (std::uint64_t step = 0; whole && step < steps_per_frame; ++step) {
      const double start = wallClock();
      const StepReport report = simulation.step();
      const double seconds = wallClock() - start;
      times.add(seconds);
      row.wall_seconds += seconds;
      worst = std::max(worst, report.status);
      whole = report.status != StepStatus::kFailed && row.wall_seconds <= patience &&
              !study.interrupted();
    }
    if (whole && frame < study.compared) {
      errors.add(study.reference, simulation.model(), simulation.state(),
                 study.reference.frames[frame]);
      for (std::size_t k = 0; k < amplitudes.size() && frame >= study.modes.first; ++k) {
        amplitudes[k].push_back(study.modes.modes[k].amplitude(simulation.state().positions));
      }
    }
  }
  row.step_median = times.quantile(0.5);
  row.totals = simulation.totals();
  row.status = whole || worst == StepStatus::kFailed ? name(worst) : "unfinished";
  if (whole) {
    const double end = (simulation.state().positions - study.reference.frames.back().positions)
                           .colwise()
                           .norm()
                           .maxCoeff();
    if (!(std::max(errors.largest, end) <= kExploded * extent(study.reference))) {
      row.status = "exploded";
    }
  }
  row.rms_error =
      whole ? std::sqrt(errors.square / std::max<std::size_t>(errors.terms, 1)) : INFINITY;
  row.max_error = whole ? errors.largest : INFINITY;
  row.energy_error = whole ? errors.energy : INFINITY;
  row.momentum_error = whole ? errors.momentum : INFINITY;
  if (!amplitudes.empty()) {
    row.mode_errors =
        whole ? compare(study.modes, amplitudes, study.frame_rate) : ModeErrors{INFINITY, INFINITY};
  }
  row.end_energy = simulation.energy().total();
  row.end_height = meanHeight(study.scene, simulation.state());
  return row;
}

}  // namespace

Eigen::Vector3d momentum(const Model& model, const State& state) {
  return state.velocities * model.masses;
}

double meanHeight(const Scene& scene, const State& state) {
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  if (scene.effects.gravity && scene.effects.gravity->acceleration.norm() > 0.0) {
    up = -scene.effects.gravity->acceleration.normalized();
  }
  return up.dot(state.positions.rowwise().mean());
}

double extent(const Reference& reference) {
  Eigen::Vector3d low = reference.frames.front().positions.rowwise().minCoeff();
  Eigen::Vector3d high = reference.frames.front().positions.rowwise().maxCoeff();
  for (const State& frame : reference.frames) {
    low = low.cwiseMin(frame.positions.rowwise().minCoeff());
    high = high.cwiseMax(frame.positions.rowwise().maxCoeff());
  }
  return (high - low).norm();
}

std::size_t framesToCompare(const Reference& reference) {
  const std::size_t frames = reference.frames.size();
  std::size_t n = 0;
  for (auto error = kStudyErrors.rbegin(); error != kStudyErrors.rend(); ++error) {
    n = reference.horizon(*error);
    if (4 * n >= frames) break;
  }
  return std::max<std::size_t>(n, 1);
}

StudyRow measure(const Study& study, const StudySetting& setting, double patience) {
  StudyRow row = runOnce(study, setting, patience);
  std::vector<double> walls = {row.wall_seconds}, medians = {row.step_median};
  while (row.usable() && walls.size() < kStudyRuns && row.wall_seconds < kLong) {
    const StudyRow again = runOnce(study, setting, INFINITY);
    if (study.interrupted()) break;
    walls.push_back(again.wall_seconds);
    medians.push_back(again.step_median);
  }
  for (std::vector<double>* values : {&walls, &medians}) {
    std::nth_element(values->begin(), values->begin() + values->size() / 2, values->end());
  }
  row.wall_seconds = walls[walls.size() / 2];
  row.step_median = medians[medians.size() / 2];
  return row;
}

}  // namespace mass_spring
