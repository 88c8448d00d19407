#include "random_scenes.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <random>

#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/scene_reader.h"
#include "mass_spring_sim/simulation.h"
#include "problems.h"

namespace mass_spring {
namespace {

/// The distributions of the standard library differ between implementations; these do not.
class Dice {
 public:
  explicit Dice(std::uint32_t seed) : engine_(seed) {}
  double between(double low, double high) { return low + (high - low) * engine_() / 4294967296.0; }
  int below(int count) { return static_cast<int>(between(0.0, count)); }
  bool chance(double probability) { return between(0.0, 1.0) < probability; }
  double decades(double low, double high) { return std::pow(10.0, between(low, high)); }
  Eigen::Vector3d box(double half) {
    const double x = between(-half, half), y = between(-half, half);
    return {x, y, between(-half, half)};
  }

 private:
  std::mt19937 engine_;
};

Particles randomParticles(Dice& dice) {
  Particles net;
  const int n = 2 + dice.below(22);
  const bool moving = dice.chance(0.5), damped = dice.chance(0.6), slack = dice.chance(0.5);
  const bool piled = dice.chance(0.2), alike = dice.chance(0.3);
  const double one_mass = dice.decades(-4.0, 2.0), one_stiffness = dice.decades(-1.0, 7.0);
  for (int i = 0; i < n; ++i) {
    const bool on_another = piled && i > 0 && dice.chance(0.5);
    net.positions.push_back(on_another ? net.positions[static_cast<std::size_t>(dice.below(i))]
                                       : dice.box(0.5));
    net.velocities.push_back(moving ? dice.box(dice.decades(-2.0, 2.0)) : Eigen::Vector3d::Zero());
    net.masses.push_back(alike ? one_mass : dice.decades(-4.0, 2.0));
  }
  net.rest_lengths.emplace();
  if (damped) net.damping.emplace();
  const auto join = [&](int i, int j) {
    if (i == j) return;
    net.springs.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j)});
    net.stiffness.push_back(alike ? one_stiffness : dice.decades(-1.0, 7.0));
    const auto& ends = net.springs.back();
    const double length = (net.positions[ends[0]] - net.positions[ends[1]]).norm();
    net.rest_lengths->push_back(dice.chance(0.05) ? 0.0
                                : slack           ? dice.between(0.1, 1.0)
                                                  : length * dice.between(0.5, 1.5));
    if (damped) net.damping->push_back(dice.decades(-3.0, 3.0));
  };
  for (int i = 1; i < n; ++i) {
    if (dice.chance(0.95)) join(i, dice.below(i));  // now and then a net in pieces
  }
  for (int k = dice.below(2 * n); k > 0; --k) {
    const int i = dice.below(n);
    join(i, dice.below(n));
  }
  return net;
}

/// A pin that is added, teleported twice and removed; pushes in between. Times are whole steps.
void addTimeline(Dice& dice, int particles, Scene& scene) {
  const auto particle = [&] { return static_cast<std::uint32_t>(dice.below(particles)); };
  if (dice.chance(0.7)) {
    PinCommand pin;
    pin.name = "grab";
    pin.object = "net";
    pin.particles = {particle()};
    pin.here = true;
    if (scene.pins.empty() || pin.particles[0] != scene.pins[0].particles[0]) {
      scene.timeline.push_back({2.0 / scene.rate, pin});
      pin.action = PinCommand::Action::kMove;
      for (const int step : {4, 10}) {
        pin.target.position = dice.box(1.0);
        scene.timeline.push_back({step / scene.rate, pin});
      }
      if (dice.chance(0.5)) {
        pin.action = PinCommand::Action::kRemove;
        scene.timeline.push_back({14 / scene.rate, pin});
      }
    }
  }
  for (int k = dice.below(4); k > 0; --k) {
    ForceCommand force;
    force.object = "net";
    force.particles = {particle()};
    force.forces = {dice.box(dice.decades(-2.0, 5.0))};
    force.duration = dice.below(3) / scene.rate;
    scene.timeline.push_back({dice.below(16) / scene.rate, force});
  }
  std::stable_sort(scene.timeline.begin(), scene.timeline.end(),
                   [](const TimedCommand& a, const TimedCommand& b) { return a.time < b.time; });
}

/// J; the tolerance of an energy that is a sum of these.
double energySize(const Simulation& simulation) {
  const Energy now = energy(simulation.model(), simulation.state());
  double gravity = 0.0;
  if (simulation.scene().effects.gravity) {
    const Eigen::Vector3d& g = simulation.scene().effects.gravity->acceleration;
    gravity =
        (simulation.state().positions.transpose() * g).cwiseAbs().dot(simulation.model().masses);
  }
  return now.kinetic + now.elastic + gravity;
}

/// Whether the pushes, all of them on the lightest particle, could carry it beyond the limits.
bool pushedBeyondLimits(const Simulation& simulation, int steps) {
  const Scene& scene = simulation.scene();
  double impulse = 0.0;  // N s; a push lasts a step at least
  for (const TimedCommand& timed : scene.timeline) {
    if (const auto* push = std::get_if<ForceCommand>(&timed.command)) {
      impulse += push->forces[0].norm() * (push->duration + 1.0 / scene.rate);
    }
  }
  const double speed = impulse / simulation.model().masses.minCoeff();
  return speed > scene.limits.max_speed || speed * steps / scene.rate > scene.limits.max_extent;
}

}  // namespace

Scene randomScene(std::uint32_t seed) {
  Dice dice(seed);
  const auto& scheme =
      schemes()[static_cast<std::size_t>(dice.below(static_cast<int>(schemes().size())))];
  const double rates[] = {1.0, 10.0, 60.0, 100.0, 1000.0};
  const double rate = rates[dice.below(5)];
  Particles net = randomParticles(dice);
  const int particles = static_cast<int>(net.positions.size());
  Scene scene = netScene(std::move(net), scheme.scheme, rate);
  scene.solver.substeps = 1 + dice.below(3);
  scene.solver.linear_solver = static_cast<LinearSolver>(dice.below(3));
  if (dice.chance(0.7)) scene.effects.gravity = GravityOptions{dice.box(10.0)};
  if (dice.chance(0.5)) pin(scene, {static_cast<std::uint32_t>(dice.below(particles))});
  addTimeline(dice, particles, scene);
  return scene;
}

std::optional<Violation> findViolation(const Scene& scene, int steps) {
  Simulation simulation(scene), again(scene);
  const bool implicit = info(scene.solver.scheme).implicit;
  const bool xpbd = scene.solver.scheme == Scheme::kXpbd;
  // With xpbd, kinetic and gravitational energy may take what the springs held; with tr_bdf2,
  // energy that was lost may come back. That may also be what a command gave and the same step
  // lost, but it is no more than a tenth of the energies before and after a step. To second-order
  // schemes, which gain and lose in turn, the engine leaves 1e-3 of them.
  const bool tr_bdf2 = scene.solver.scheme == Scheme::kTrBdf2;
  const double share = tr_bdf2 ? 0.2 : 2.2e-3;
  double ever = 0.0;  // J, the most energy that there was
  const bool beyond = pushedBeyondLimits(simulation, steps);
  bool commanded = false;
  simulation.observeTimeline([&](const Command&, const CommandResult&) { commanded = true; });
  for (int n = 0; n < steps; ++n) {
    const bool pushed = simulation.activeForces() > 0;
    const double there = energy(simulation.model(), simulation.state()).total();
    ever = n == 0 ? there : std::max(ever, there);
    const double before = xpbd || tr_bdf2 ? ever : there;
    const double size = energySize(simulation);
    commanded = false;
    const StepReport report = simulation.step();
    const State& state = simulation.state();
    const auto violation = [&](const std::string& what) {
      return Violation{static_cast<std::uint64_t>(n + 1),
                       what + " (" + name(report.status) + " " + report.message + ")"};
    };
    if (firstNotFinite(state)) return violation("not finite");
    if (report.status != StepStatus::kConverged && report.message.empty()) {
      return violation("no reason given");
    }
    if (report.status == StepStatus::kFailed && beyond &&
        report.message.find("limits.") != std::string::npos) {
      return std::nullopt;  // 1e5 N for 2 s move 0.1 g beyond any limit
    }
    if (implicit && report.status == StepStatus::kFailed) return violation("failed");
    const Energy now = energy(simulation.model(), state);
    const double after = xpbd ? now.kinetic + now.gravity : now.total();
    const double tolerance = share * std::max(size, energySize(simulation));
    if (implicit && !pushed && !commanded && !(after <= before + tolerance)) {
      return violation("energy from nowhere: " + std::to_string(after - before) + " J, was " +
                       std::to_string(before) + " J");
    }
    if (again.step().status != report.status ||
        !sameBytes(again.state().positions, state.positions) ||
        !sameBytes(again.state().velocities, state.velocities)) {
      return violation("other bytes on the second run");
    }
    if (report.status == StepStatus::kFailed) return std::nullopt;
  }
  return std::nullopt;
}

std::string reproduction(std::uint32_t seed, const Scene& scene, int steps,
                         const Violation& violation, const std::string& folder) {
  const std::string file = folder + "/random_scene_" + std::to_string(seed) + ".yaml";
  std::ofstream(file) << toYaml(scene);
  return "seed " + std::to_string(seed) + ", " + info(scene.solver.scheme).name + ", step " +
         std::to_string(violation.step) + ": " + violation.what + "\nsimulate --scene " + file +
         " --duration " + std::to_string(steps / scene.rate);
}

}  // namespace mass_spring
