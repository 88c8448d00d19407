#include "mass_spring_sim/scene_reader.h"

#include <algorithm>
#include <filesystem>

#include "scene/calibration_reader.h"
#include "scene/effects_reader.h"
#include "scene/object_reader.h"
#include "scene/references.h"
#include "scene/timeline_reader.h"
#include "scene/tree_reader.h"

namespace mass_spring {
namespace {

// Hz of ~state where the scene does not say it: each step, until that is more than clients expect.
constexpr double kMostStates = 1000.0;

void readSolver(const Place& place, const std::string& directory, SolverOptions& solver) {
  static const NumberRule kTolerance{"", 0.0, 1.0, true};
  MapReader keys(place, "a map of solver options");
  std::size_t index = 0;
  const Place scheme = keys.optional("scheme"), accuracy = keys.optional("accuracy");
  if (scheme.read(index, schemeNames())) {
    solver.scheme = static_cast<Scheme>(index);
  } else if (accuracy.present() && !scheme.present()) {
    solver.scheme = Scheme::kAuto;  // whoever asks for an accuracy need not know schemes
  }
  keys.optional("substeps").read(solver.substeps, 1, 100000);
  keys.optional("newton_tolerance").read(solver.newton_tolerance, kTolerance);
  keys.optional("max_newton_iterations").read(solver.max_newton_iterations, 1, 1000);
  if (keys.optional("linear_solver").read(index, linearSolverNames())) {
    solver.linear_solver = static_cast<LinearSolver>(index);
  }
  keys.optional("linear_tolerance").read(solver.linear_tolerance, kTolerance);
  keys.optional("max_linear_iterations").read(solver.max_linear_iterations, 1, 1000000);
  const bool estimates = solver.scheme == Scheme::kAuto || info(solver.scheme).estimates;
  if (accuracy.read(solver.accuracy, positive("m")) && !estimates) {
    accuracy.refuse(
        "a scheme with an estimate of its error: symplectic_euler, rk4, tr_bdf2, ros3 or auto");
  }
  readCalibration(keys.optional("calibration"), directory, solver);
  const Place budget = keys.optional("budget");
  if (budget.read(solver.budget, positive("s")) && solver.accuracy) {
    budget.refuse("either accuracy or budget");
  }
  keys.optional("threads").read(solver.threads, 0, 256);
  keys.refuseUnknown();
}

/// @param rate  Hz, of the scene
void readPublish(const Place& place, double rate, PublishRates& rates) {
  static const NumberRule kRate{"Hz, 0 = never", 0.0, 10000.0};
  rates.state = std::min(rate, kMostStates);
  MapReader keys(place, "a map of rates");
  keys.optional("markers").read(rates.markers, kRate);
  keys.optional("state").read(rates.state, kRate);
  keys.optional("points").read(rates.points, kRate);
  keys.optional("pins").read(rates.pins, kRate);
  keys.optional("contacts").read(rates.contacts, kRate);
  keys.optional("stats").read(rates.stats, kRate);
  keys.refuseUnknown();
}

void readLimits(const Place& place, Limits& limits) {
  MapReader keys(place, "a map of limits");
  keys.optional("max_force").read(limits.max_force, positive("N"));
  keys.optional("max_speed").read(limits.max_speed, {"m/s", 1e-6, kLargestCoordinate});
  keys.optional("max_extent").read(limits.max_extent, {"m", 1e-6, kLargestCoordinate});
  keys.refuseUnknown();
}

}  // namespace

Scene readScene(const Tree& tree, const std::string& directory) {
  Problems problems;
  Scene scene;
  MapReader keys(Place(&tree, "", true, problems), "a map with objects");
  readFrame(keys.optional("frame_id"), scene.frame_id);
  keys.optional("rate").read(scene.rate, {"Hz", 1.0, 10000.0});
  keys.optional("real_time_factor").read(scene.real_time_factor, {"", 0.0, 100.0});
  keys.optional("start_paused").read(scene.start_paused);
  readSolver(keys.optional("solver"), directory, scene.solver);
  ParticleCounts counts;
  const std::size_t problems_elsewhere = problems.count();
  scene.objects = readObjects(keys.required("objects"), directory, counts);
  const std::size_t problems_before = problems.count();
  const bool objects_are_good = problems_before == problems_elsewhere;
  PinLedger ledger;
  scene.pins = readPins(keys.optional("pins"), counts, ledger);
  const bool pins_are_good = problems.count() == problems_before;
  const std::size_t problems_before_effects = problems.count();
  readEffects(keys.optional("effects"), objects_are_good ? &scene.objects : nullptr, scene.effects);
  const bool effects_are_good = problems.count() == problems_before_effects;
  std::vector<std::string> shapes;
  if (scene.effects.contact) {
    for (const ContactShape& shape : scene.effects.contact->shapes) shapes.push_back(shape.name);
  }
  const Place timeline = keys.optional("timeline");
  readPublish(keys.optional("publish"), scene.rate, scene.publish);
  readLimits(keys.optional("limits"), scene.limits);
  scene.timeline = readTimeline(timeline, counts, scene.limits,
                                pins_are_good ? std::optional(std::move(ledger)) : std::nullopt,
                                effects_are_good ? &shapes : nullptr);
  keys.refuseUnknown();
  problems.throwIfAny();
  return scene;
}

Scene readSceneFile(const std::string& path) {
  const auto directory = std::filesystem::path(path).parent_path();
  return readScene(readYamlFile(path), directory.empty() ? "." : directory.string());
}

}  // namespace mass_spring
