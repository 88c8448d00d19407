#include "hard_cases_watch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/scene_reader.h"

namespace mass_spring {

double Trial::damping() const { return std::sqrt(stiffness); }

void Trial::add(const void* data, std::size_t size) {
  const auto* bytes = static_cast<const unsigned char*>(data);
  for (std::size_t i = 0; i < size; ++i) fingerprint = (fingerprint ^ bytes[i]) * 1099511628211u;
}

bool dampsWhatIsStiff(Scheme scheme) {
  return solvesSprings(scheme) && info(scheme).name != "implicit_midpoint";
}

double momentumRounding(const Trial& trial, double k_l, double mass, int steps) {
  return 1e-12 + 1e-12 * steps * steps * trial.h * trial.h * k_l / mass;
}

Scene sceneOf(const Trial& trial, Particles net) {
  return netScene(std::move(net), trial.scheme, trial.rate());
}

namespace {

Particles scaled(const Trial& trial, Particles net) {
  for (double& k : net.stiffness) k *= trial.stiffness;
  for (double& c : *net.damping) c *= trial.damping();
  return net;
}

}  // namespace

Particles sheet(const Trial& trial, int n) {
  return scaled(trial, byHand(hangingCloth(n, trial.scheme)));
}

Particles block(const Trial& trial, int n) {
  Lattice shape;
  shape.size = Eigen::Vector3d(0.3, 0.3, 0.3);
  shape.resolution = {n, n, n};
  shape.mass = 0.5;
  shape.stiffness = 500.0;
  shape.shear_stiffness = 250.0;
  shape.damping = 1.0;
  Scene scene;
  scene.objects.push_back({"block", Eigen::Vector4d(1, 1, 1, 1), shape});
  return scaled(trial, byHand(scene));
}

void addGravity(Scene& scene) {
  scene.effects.gravity = GravityOptions{Eigen::Vector3d(0, 0, -9.81)};
}

Watched::Watched(Trial& trial, Scene scene) : trial_(trial), simulation_(std::move(scene)) {}

void Watched::boundEnergy(double share) {
  energy_share_ = share;
  energy_is_bounded_ = true;
  energy_bound_ = energy(simulation_.model(), simulation_.state()).total();
}

double Watched::energySize() const {
  // What the energies are made of is larger than their sum, as gravity's counts from anywhere.
  const Energy now = energy(simulation_.model(), simulation_.state());
  return now.kinetic + now.elastic + std::abs(now.gravity) + std::abs(energy_bound_);
}

StepReport Watched::step(int steps) {
  StepReport report;
  for (int n = 0; n < steps && !failed_; ++n) {
    const Vectors before = simulation_.state().positions;
    report = simulation_.step();
    check(report, before);
    if (report.status == StepStatus::kFailed) break;
  }
  return report;
}

void Watched::check(const StepReport& report, const Vectors& before) {
  const State& state = simulation_.state();
  const auto size = sizeof(double) * static_cast<std::size_t>(state.positions.size());
  trial_.add(state.positions.data(), size);
  trial_.add(state.velocities.data(), size);
  trial_.add(&report.status, sizeof report.status);

  if (report.status == StepStatus::kDegraded) ever_degraded_ = true;
  if (report.status != StepStatus::kConverged && report.message.empty()) {
    return violation(std::string(name(report.status)) + ", but it does not say why");
  }
  if (report.status == StepStatus::kFailed && !may_fail_) {
    return violation("failed: " + report.message);
  }
  if (firstNotFinite(state)) return violation("not finite");
  if (report.status == StepStatus::kConverged && !std::isfinite(report.residual)) {
    return violation("converged with a residual that is not finite");
  }
  if (frozen(report, before)) return violation("frozen: " + report.message);
  if (!energy_is_bounded_) return;
  const Energy now = energy(simulation_.model(), state);
  const double held = trial_.scheme == Scheme::kXpbd ? now.elastic : 0.0;
  const double excess = now.total() - held - energy_bound_;
  if (!(excess <= energy_share_ * energySize())) {
    violation("energy " + std::to_string(excess) + " J above " + std::to_string(energy_bound_) +
              " J, " + name(report.status) + " " + report.message);
  }
}

bool Watched::frozen(const StepReport& report, const Vectors& before) const {
  // Giving up looks like rest: nothing has moved, and the equations are not solved. Velocities of
  // zero alone are no sign of it: a net that relaxes within a step is at rest at its end, whatever
  // residual the first of its sub-steps left.
  return report.residual > 1e-3 && simulation_.state().positions == before;
}

void Watched::violation(const std::string& what) {
  failed_ = true;
  std::string file = trial_.name + ".yaml";
  std::replace(file.begin(), file.end(), '/', '_');
  const auto path = std::filesystem::path(testing::TempDir()) / file;
  std::ofstream(path) << toYaml(simulation_.scene());
  ADD_FAILURE() << trial_.name << ", step " << simulation_.state().step << ": " << what
                << "\nthe scene, without commands that came later: " << path.string();
}

}  // namespace mass_spring
