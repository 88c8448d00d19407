#include "tools/reference.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "mass_spring_sim/simulation.h"
#include "scheme_choice.h"
#include "tools/closed_form.h"
#include "tools/wall_clock.h"

namespace mass_spring {
namespace {

// Of the largest stable step, to begin with: what moves visibly is far slower than the fastest
// oscillation, and the doubt tells.
constexpr double kShare = 0.6;
constexpr double kLongestStep = 5e-4;  // s
constexpr double kApart = 1e-9;        // m
constexpr double kPredictable = 1e-3;  // m
constexpr int kMostSubsteps = 100000;

std::vector<State> run(Scene scene, int substeps, const ReferenceOptions& options) {
  scene.solver.scheme = Scheme::kRk4;
  scene.solver.substeps = substeps;
  scene.solver.accuracy.reset();
  scene.solver.budget.reset();
  Simulation simulation(std::move(scene));
  const auto steps_per_frame =
      static_cast<std::uint64_t>(std::lround(simulation.scene().rate / options.frame_rate));
  const auto frames =
      static_cast<std::size_t>(std::ceil(options.duration * options.frame_rate - 1e-9));
  std::vector<State> states;
  while (states.size() < frames) {
    for (std::uint64_t step = 0; step < steps_per_frame; ++step) {
      const StepReport report = simulation.step();
      if (report.status == StepStatus::kFailed) {
        throw std::runtime_error("the reference, rk4, failed: " + report.message);
      }
      if (options.interrupted()) throw std::runtime_error("interrupted within the reference");
    }
    states.push_back(simulation.state());
  }
  return states;
}

}  // namespace

Scene movedApart(const Scene& scene, double apart, std::size_t start) {
  const Model model = buildModel(scene);
  Scene moved = scene;
  for (std::size_t o = 0; o < model.objects.size(); ++o) {
    const ModelObject& object = model.objects[o];
    Particles particles;
    particles.damping.emplace();
    particles.rest_lengths.emplace();
    for (std::uint32_t p = 0; p < object.particle_count; ++p) {
      const Eigen::Index i = object.first_particle + p;
      const double k = 1.0 + static_cast<double>(start);
      const Eigen::Vector3d direction(std::sin(k * (1.0 + i)), std::sin(k * (2.0 + 3.0 * i)),
                                      std::sin(k * (3.0 + 7.0 * i)));
      particles.positions.push_back(model.start.positions.col(i) + apart * direction);
      particles.velocities.push_back(model.start.velocities.col(i));
      particles.masses.push_back(model.masses[i]);
    }
    for (std::uint32_t s = 0; s < object.spring_count; ++s) {
      const Spring& spring = model.springs[object.first_spring + s];
      particles.springs.push_back(
          {spring.i - object.first_particle, spring.j - object.first_particle});
      particles.stiffness.push_back(spring.stiffness);
      particles.damping->push_back(spring.damping);
      particles.rest_lengths->push_back(spring.rest_length);
    }
    moved.objects[o].shape = particles;
  }
  return moved;
}

double Reference::distance(const Vectors& a, const Vectors& b) const {
  double square = 0.0;
  int free = 0;
  for (Eigen::Index i = 0; i < a.cols(); ++i) {
    if (pinned[static_cast<std::size_t>(i)]) continue;
    square += (a.col(i) - b.col(i)).squaredNorm();
    ++free;
  }
  return free > 0 ? std::sqrt(square / free) : 0.0;
}

std::size_t Reference::horizon(double error) const {
  const auto reached =
      std::find_if(spread.begin(), spread.end(), [&](double s) { return !(s < error); });
  return static_cast<std::size_t>(reached - spread.begin());
}

double Reference::largestDoubt(std::size_t frames) const {
  return frames == 0 ? 0.0 : *std::max_element(doubt.begin(), doubt.begin() + frames);
}

Reference findReference(const Scene& scene, const ReferenceOptions& options) {
  const double end = wallClock() + options.seconds;
  const double stable = stableRk4Step(boundSpectrum(buildModel(scene)));
  const double h = 1.0 / scene.rate;
  int substeps =
      std::max(1, static_cast<int>(std::ceil(h / std::min(kShare * stable, kLongestStep))));
  Reference reference;
  reference.rate = scene.rate;
  reference.pinned = Simulation(scene).pins().mask();
  const auto compare = [&](const std::vector<State>& others) {
    std::vector<double> distances;
    for (std::size_t n = 0; n < others.size(); ++n) {
      distances.push_back(reference.distance(others[n].positions, reference.frames[n].positions));
    }
    return distances;
  };
  std::vector<State> coarse = run(scene, substeps, options);
  reference.frames = coarse;
  const double first = wallClock();
  const auto runApart = [&] {
    return run(movedApart(scene, kApart, reference.ends.size()), substeps, options);
  };
  const std::vector<State> apart = runApart();
  const double seconds = wallClock() - first;
  reference.spread = compare(apart);
  reference.ends.push_back(apart.back());
  const double more = wallClock() + options.starts_seconds;
  while (reference.horizon(kPredictable) < apart.size() && reference.ends.size() < kStarts &&
         wallClock() + seconds <= more) {
    reference.ends.push_back(runApart().back());
  }
  std::vector<double> times;
  for (const State& state : coarse) times.push_back(state.time);
  if (std::optional<std::vector<State>> states = closedForm(scene, times)) {
    reference.exact = true;
    reference.substeps = substeps;
    reference.frames = std::move(*states);
    reference.doubt = compare(coarse);
    return reference;
  }
  for (;;) {
    const double start = wallClock();
    substeps *= 2;
    reference.frames = run(scene, substeps, options);
    reference.substeps = substeps;
    reference.doubt = compare(coarse);
    const double doubt = reference.largestDoubt(reference.horizon(options.finest));
    const double next = wallClock() + 2.0 * (wallClock() - start);
    if (doubt <= options.doubt || next > end || 2 * substeps > kMostSubsteps) return reference;
    coarse = std::move(reference.frames);
  }
}

}  // namespace mass_spring
