#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "hard_cases_checks.h"
#include "mass_spring_sim/measures.h"

// Starts that plain code does not survive.
namespace mass_spring {
namespace {

Eigen::Vector3d centerOfMass(const Simulation& simulation) {
  const Model& model = simulation.model();
  return simulation.state().positions * model.masses / model.masses.sum();
}

double strongest(const Particles& net) {
  return *std::max_element(net.stiffness.begin(), net.stiffness.end());
}

/// The sheet's springs along rows and columns alone: with shear springs a crumpled sheet can lock,
/// and then rests stretched.
Particles threads(const Trial& trial, int n) {
  const Particles all = sheet(trial, n);
  Particles net = all;
  net.springs.clear(), net.stiffness.clear(), net.damping->clear(), net.rest_lengths->clear();
  for (std::size_t s = 0; s < all.springs.size(); ++s) {
    if (all.stiffness[s] < strongest(all)) continue;
    net.springs.push_back(all.springs[s]);
    net.stiffness.push_back(all.stiffness[s]);
    net.damping->push_back((*all.damping)[s]);
    net.rest_lengths->push_back((*all.rest_lengths)[s]);
  }
  return net;
}

/// Lets a sheet go from wherever its particles are: it unfolds, gains no energy, and is no longer
/// stretched once it has.
void unfolds(Trial& trial, Particles net) {
  for (double& c : *net.damping) c *= 10.0;  // a fifth of critical
  const double k = strongest(net), mass = 0.2;
  Watched run(trial, sceneOf(trial, std::move(net)));
  const Eigen::Vector3d center = centerOfMass(*run);
  run.boundEnergy();
  const int steps = 60;
  run.step(steps);
  if (run.failed()) return;
  EXPECT_LT((centerOfMass(*run) - center).norm(), momentumRounding(trial, k, mass, steps));
  if (dampsWhatIsStiff(trial.scheme)) {
    EXPECT_LT(maxStretch(run->model(), run->state()), 1.01);
  }
}

}  // namespace

void coincidentEnds(Trial& trial) {
  Particles pair;
  pair.positions = {Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(1, 2, 3)};
  pair.masses = {0.1, 0.2};
  pair.springs = {{0, 1}};
  pair.stiffness = {100.0 * trial.stiffness};
  // Critical: 2 sqrt(k mu), mu = 1/15 kg.
  pair.damping = {{2.0 * std::sqrt(100.0 * trial.stiffness / 15.0)}};
  pair.rest_lengths = {{0.5}};
  Watched run(trial, sceneOf(trial, pair));
  run.boundEnergy();
  run.step(120);
  const Vectors& x = run->state().positions;
  const double length = (x.col(1) - x.col(0)).norm();
  if (dampsWhatIsStiff(trial.scheme)) {
    EXPECT_NEAR(length, 0.5, 0.005);  // 1 % of the rest length
  } else {
    EXPECT_GT(length, 0.0);  // still ringing
  }
  EXPECT_LT((centerOfMass(*run) - Eigen::Vector3d(1, 2, 3)).norm(),
            momentumRounding(trial, 50.0 * trial.stiffness, 0.3, 120));
}

// A spring of rest length 0 is linear in three dimensions, so trajectories superpose: one from an
// oblique start with an oblique velocity is the sum of two from unit starts, the ends meeting or
// not.
void restLengthZero(Trial& trial) {
  const Eigen::Vector3d start(0.3, -0.2, 0.1), velocity(-2.0, 1.0, 0.5);
  const auto released = [&](const Eigen::Vector3d& x, const Eigen::Vector3d& v) {
    Particles pair;
    pair.positions = {Eigen::Vector3d::Zero(), x};
    pair.velocities = {Eigen::Vector3d::Zero(), v};
    pair.masses = {1.0, 0.3};
    pair.springs = {{0, 1}};
    pair.stiffness = {40.0 * trial.stiffness};
    pair.rest_lengths = {{0.0}};
    Scene scene = sceneOf(trial, pair);
    pin(scene, {0});
    return scene;
  };
  Watched run(trial, released(start, velocity));
  Watched from_place(trial, released(Eigen::Vector3d::UnitX(), Eigen::Vector3d::Zero()));
  Watched from_speed(trial, released(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX()));
  for (int n = 0; n < 60; ++n) {
    run.step();
    from_place.step();
    from_speed.step();
    if (run.failed() || from_place.failed() || from_speed.failed()) return;
    const Eigen::Vector3d expected = from_place->state().positions(0, 1) * start +
                                     from_speed->state().positions(0, 1) * velocity;
    // 1e-12: rounding of numbers of size 1 over 60 steps.
    EXPECT_LT((run->state().positions.col(1) - expected).norm(), 1e-12) << "step " << n;
  }
  EXPECT_FALSE(run.everDegraded());
}

void allAtOnePoint(Trial& trial) {
  Particles net = randomNet(20, 100.0 * trial.stiffness, 1.0, 11);
  net.damping.emplace(net.springs.size(), 0.1 * trial.damping());
  std::fill(net.positions.begin(), net.positions.end(), Eigen::Vector3d(1, 2, 3));
  Watched run(trial, sceneOf(trial, net));
  run.boundEnergy();
  run.step(30);
  EXPECT_LT((centerOfMass(*run) - Eigen::Vector3d(1, 2, 3)).norm(),
            momentumRounding(trial, 150.0 * trial.stiffness, 0.4, 30));
  EXPECT_GT(maxStretch(run->model(), run->state()),
            dampsWhatIsStiff(trial.scheme) ? 0.1 : 0.0);  // the midpoint rule keeps them ringing
}

void compressedToOnePercent(Trial& trial) {
  Particles net = block(trial, 4);
  for (auto& x : net.positions) x *= 0.01;
  Watched run(trial, sceneOf(trial, net));
  run.boundEnergy();
  const StepReport first = run.step();
  // Per sub-step: two stages of tr_bdf2 are two solves of Newton each.
  EXPECT_LE(first.newton_iterations, 50u * first.substeps) << first.message;
  run.step(10);
}

// r = 1 - L/l = -1e-4: a little indefinite across the sheet, where nothing shows it yet.
void flatSheetCompressed(Trial& trial) {
  Particles net = sheet(trial, 8);
  for (auto& x : net.positions) x *= 0.9999;
  Watched run(trial, sceneOf(trial, net));
  run.boundEnergy();
  run.step(20);
  // ros3 has no projection: its third order needs the exact derivative. The ladder catches it.
  EXPECT_TRUE(!run.everDegraded() || trial.scheme == Scheme::kRos3);
  // Across the sheet there is no force at all.
  EXPECT_EQ(run->state().positions.row(2).cwiseAbs().maxCoeff(), 0.0);
}

void scrambledStart(Trial& trial) {
  Particles net = threads(trial, 5);
  std::mt19937 random(6);
  std::uniform_real_distribution<double> unit(-0.5, 0.5);
  for (auto& x : net.positions) {
    const double a = unit(random), b = unit(random), c = unit(random);
    x = Eigen::Vector3d(a, b, c);
  }
  unfolds(trial, std::move(net));
}

void flattenedStart(Trial& trial) {
  Particles net = threads(trial, 5);
  for (auto& x : net.positions) x = Eigen::Vector3d(0.01 * x.x(), x.y(), 0.0);
  unfolds(trial, std::move(net));
}

void longStep(Trial& trial) {
  Scene scene = sceneOf(trial, sheet(trial, 6));
  addGravity(scene);
  pin(scene, {0, 5});
  Watched run(trial, scene);
  run.boundEnergy();
  run.step(10);
}

// The rim moves at 1000 rad/s * 0.1 m; the springs could hold it only at k > 1e6 times the mass.
void spinningRing(Trial& trial) {
  const int n = 20;
  const double radius = 0.1, speed = 1000.0;
  Particles ring;
  for (int i = 0; i < n; ++i) {
    const double angle = 2.0 * M_PI * i / n;
    ring.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0.0);
    ring.velocities.emplace_back(-radius * speed * std::sin(angle),
                                 radius * speed * std::cos(angle), 0.0);
    ring.masses.push_back(0.01);
    ring.springs.push_back(
        {static_cast<std::uint32_t>(i), static_cast<std::uint32_t>((i + 1) % n)});
    ring.stiffness.push_back(1000.0 * trial.stiffness);
  }
  Watched run(trial, sceneOf(trial, ring));
  run.boundEnergy();
  run.step(30);
}

}  // namespace mass_spring
