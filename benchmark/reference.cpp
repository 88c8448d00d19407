#include "reference.h"

#include <algorithm>
#include <cmath>

#include "mass_spring_sim/simulation.h"
#include "scheme_choice.h"

namespace mass_spring {
namespace {

// A quarter of the largest stable step: rk4 then errs by 1e-4 of a radian per radian of the fastest
// oscillation, and by far less on all that moves visibly.
constexpr double kShare = 0.25;
constexpr double kLongestStep = 5e-4;  // s
constexpr double kApart = 1e-9;        // m

/// The same scene particle by particle, each moved by `apart` [m] in a direction of its own.
Scene movedApart(const Scene& scene, double apart) {
  const Model model = buildModel(scene);
  Scene moved = scene;
  for (std::size_t o = 0; o < model.objects.size(); ++o) {
    const ModelObject& object = model.objects[o];
    Particles particles;
    particles.damping.emplace();
    particles.rest_lengths.emplace();
    for (std::uint32_t p = 0; p < object.particle_count; ++p) {
      const Eigen::Index i = object.first_particle + p;
      const Eigen::Vector3d direction(std::sin(1.0 + i), std::sin(2.0 + 3.0 * i),
                                      std::sin(3.0 + 7.0 * i));
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

std::vector<Vectors> run(Scene scene, int substeps, int frames) {
  scene.solver.scheme = Scheme::kRk4;
  scene.solver.substeps = substeps;
  Simulation simulation(std::move(scene));
  std::vector<Vectors> positions;
  for (int frame = 0; frame < frames; ++frame) {
    if (simulation.step().status == StepStatus::kFailed) break;
    positions.push_back(simulation.state().positions);
  }
  return positions;
}

}  // namespace

double Reference::distance(const Vectors& a, const Vectors& b) const {
  double square = 0.0;
  int free = 0;
  for (Eigen::Index i = 0; i < a.cols(); ++i) {
    if (pinned[static_cast<std::size_t>(i)]) continue;
    square += (a.col(i) - b.col(i)).squaredNorm();
    ++free;
  }
  return std::sqrt(square / free);
}

Reference findReference(const Scene& scene, double duration, double tolerance) {
  const double stable = stableRk4Step(boundSpectrum(buildModel(scene)));
  const double h = 1.0 / scene.rate;
  const int substeps = static_cast<int>(std::ceil(h / std::min(kShare * stable, kLongestStep)));
  const int frames = static_cast<int>(std::lround(duration * scene.rate));
  Reference reference;
  reference.frames = run(scene, 2 * substeps, frames);
  reference.pinned = Simulation(scene).pins().mask();
  const std::vector<Vectors> coarse = run(scene, substeps, frames);
  const std::vector<Vectors> apart = run(movedApart(scene, kApart), substeps, frames);
  std::size_t n = 0;
  for (; n < std::min({reference.frames.size(), coarse.size(), apart.size()}); ++n) {
    if (!(reference.distance(coarse[n], apart[n]) < tolerance)) break;
    const double difference = reference.distance(coarse[n], reference.frames[n]);
    reference.difference = std::max(reference.difference, difference);
  }
  reference.whole = n == static_cast<std::size_t>(frames);
  reference.frames.resize(n);
  return reference;
}

}  // namespace mass_spring
