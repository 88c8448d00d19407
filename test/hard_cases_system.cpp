#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "effects/effect.h"
#include "hard_cases_checks.h"
#include "mass_spring_sim/measures.h"
#include "probe.h"
#include "sanitizers.h"
#include "solvers/linear_system.h"

// Systems of equations that plain solvers do not solve.
namespace mass_spring {
namespace {

const Eigen::Vector3d kDown(0, 0, -1);

/// Every second step of 1e8 times the stiffness.
void contrast(Particles& net) {
  for (std::size_t s = 0; s < net.stiffness.size(); s += 2) net.stiffness[s] *= 1e8;
}

}  // namespace

void stiffnessRatioInChain(Trial& trial) {
  Particles net = chain(30, 0.1, kDown, 0.01, 10.0 * trial.stiffness);
  contrast(net);
  Scene scene = sceneOf(trial, net);
  addGravity(scene);
  pin(scene, {0});
  Watched run(trial, scene);
  run.boundEnergy();
  for (int n = 0; n < 20 && !run.failed(); ++n) {
    const StepReport report = run.step();
    EXPECT_LE(report.residual, scene.solver.newton_tolerance) << report.message;
    EXPECT_EQ(report.linear_iterations, 0u);  // a direct solver, by itself
  }
  // Steps of 1 s are redone in parts where one linear system leaves 1e-6 of a residual (condition
  // numbers reach 1e16), and where the midpoint rule gains energy.
  EXPECT_TRUE(!run.everDegraded() || trial.h > 0.5);
}

void stiffnessRatioInSheet(Trial& trial) {
  Particles net = sheet(trial, 10);
  std::mt19937 random(8);
  std::uniform_real_distribution<double> decades(-4.0, 4.0);
  for (double& k : net.stiffness) k *= std::pow(10.0, decades(random));
  Scene scene = sceneOf(trial, net);
  addGravity(scene);
  pin(scene, {0, 9});
  Watched run(trial, scene);
  run.boundEnergy();
  run.step(underSanitizers() ? 1 : 3);
}

void loadOnLightRope(Trial& trial) {
  const int links = 20;
  const double load = 1000.0, k = 1e7 * trial.stiffness;
  Particles net = chain(links, 0.1, kDown, 0.001, k);
  net.masses.back() = load;
  // Critical for the load on the whole rope: c / links = 2 sqrt(k / links * load).
  net.damping.emplace(net.springs.size(), 2.0 * links * std::sqrt(k / links * load));
  Scene scene = sceneOf(trial, net);
  addGravity(scene);
  pin(scene, {0});
  Watched run(trial, scene);
  run.boundEnergy();
  run.step(300);
  double sag = 0.0;
  for (int i = 1; i <= links; ++i) sag += (load + 0.001 * (links - i)) * kGravity / k;
  // A glitch of the heavy load shows in percents; 300 steps leave less than a tenth of one.
  EXPECT_NEAR(-run->state().positions(2, links) - 0.1 * links, sag, 1e-3 * sag);
}

void allPinned(Trial& trial) {
  Scene scene = sceneOf(trial, sheet(trial, 4));
  addGravity(scene);
  std::vector<std::uint32_t> all(16);
  for (std::uint32_t i = 0; i < 16; ++i) all[i] = i;
  pin(scene, all);
  Watched run(trial, scene);
  for (int n = 0; n < 5; ++n) {
    const StepReport report = run.step();
    EXPECT_EQ(report.status, StepStatus::kConverged);
    EXPECT_EQ(report.linear_iterations + report.factorizations, 0u);
  }
  // 1e-15: offsets taken off and added again.
  EXPECT_LT((run->state().positions - run->model().start.positions).norm(), 1e-15);
}

void isolatedParticle(Trial& trial) {
  Particles net = sheet(trial, 4);
  net.positions.emplace_back(0.3, 0.1, 2.0);
  net.velocities.emplace_back(0.5, -0.25, 1.0);
  net.masses.push_back(0.7);
  Scene scene = sceneOf(trial, net);
  addGravity(scene);
  pin(scene, {0, 3});
  Watched run(trial, scene);
  const SchemeInfo& scheme = info(trial.scheme);
  // From the second order on a parabola is exact; of the first, as closed form 1 has it.
  const double shift = scheme.order > 1 ? 0.0 : scheme.name == "explicit_euler" ? -1.0 : 1.0;
  for (int n = 1; n <= 10; ++n) {
    run.step();
    if (run.failed()) return;
    const double t = n * trial.h;
    const Eigen::Vector3d expected = net.positions[16] + t * net.velocities[16] +
                                     kGravity * trial.h * trial.h * n * (n + shift) / 2.0 * kDown;
    if (run.everDegraded()) continue;  // sub-steps of another scheme fall otherwise
    // 1e-12 of some 500 m at h = 1 s: rounding.
    EXPECT_LT((run->state().positions.col(16) - expected).norm(), 1e-12 * (1.0 + expected.norm()));
  }
}

void springBothWays(Trial& trial) {
  Particles net = randomNet(10, 50.0 * trial.stiffness, 0.9, 9);
  Particles twice = net, stiff = net;
  for (std::size_t s = 0; s < net.springs.size(); ++s) {
    twice.springs.push_back({net.springs[s][1], net.springs[s][0]});
    twice.stiffness.push_back(net.stiffness[s]);
    twice.rest_lengths->push_back((*net.rest_lengths)[s]);
    stiff.stiffness[s] *= 2.0;
  }
  const auto tight = [&](const Particles& particles) {
    Scene scene = sceneOf(trial, particles);
    // 1e-12 is asked of the answer, and the default 1e-6 of solvers that sum the two springs of a
    // pair in one order or the other: what they leave differs by as much.
    scene.solver.newton_tolerance = 1e-12;
    scene.solver.linear_tolerance = 1e-13;
    return scene;
  };
  Watched a(trial, tight(twice)), b(trial, tight(stiff));
  // The second step is the first that bdf2 makes by its own formula. Rounding, which differs from
  // compiler to compiler, grows with each step of such a stiff net.
  a.step(2);
  b.step(2);
  if (a.failed() || b.failed()) return;
  EXPECT_LT((a->state().positions - b->state().positions).norm(), 1e-12);
}

void thousandComponents(Trial& trial) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Particles all;
  all.rest_lengths.emplace();
  std::vector<Particles> alone;
  const int components = underSanitizers() ? 100 : 1000;
  // Each swings from its first particle.
  const auto scene = [&](const Particles& net) {
    Scene built = sceneOf(trial, net);
    // Both are solved to their tolerances; equal to 1e-9 they can be only below those.
    built.solver.newton_tolerance = 1e-12;
    built.solver.linear_tolerance = 1e-12;
    addGravity(built);
    std::vector<std::uint32_t> held;
    for (std::uint32_t i = 0; i < net.positions.size(); i += 3) held.push_back(i);
    pin(built, held);
    return built;
  };
  for (int c = 0; c < components; ++c) {
    // Triangles, each of its own stiffness, over a decade.
    Particles net = randomNet(3, trial.stiffness * std::pow(10.0, 1.0 + unit(random)), 1.0,
                              static_cast<unsigned>(c));
    const auto first = static_cast<std::uint32_t>(all.positions.size());
    all.positions.insert(all.positions.end(), net.positions.begin(), net.positions.end());
    all.masses.insert(all.masses.end(), net.masses.begin(), net.masses.end());
    for (const auto& s : net.springs) all.springs.push_back({s[0] + first, s[1] + first});
    all.stiffness.insert(all.stiffness.end(), net.stiffness.begin(), net.stiffness.end());
    all.rest_lengths->insert(all.rest_lengths->end(), net.rest_lengths->begin(),
                             net.rest_lengths->end());
    if (c % (components / 5) == 0) alone.push_back(net);
  }
  Watched together(trial, scene(all));
  together.step(3);
  EXPECT_FALSE(together.everDegraded());  // what one gets, all would get
  int compared = 0;
  for (std::size_t k = 0; k < alone.size() && !together.failed(); ++k) {
    Watched run(trial, scene(alone[k]));
    run.step(3);
    if (run.failed()) return;
    // A gain of energy that is none in the sum of all may be too much for one (the midpoint rule).
    if (run.everDegraded()) continue;
    ++compared;
    const auto first = static_cast<Eigen::Index>(k) * (components / 5) * 3;
    const Vectors theirs = together->state().positions.middleCols(first, 3);
    // 1e-9 m: both solved to 1e-12 of some 0.5 m, in directions that move easily.
    EXPECT_LT((theirs - run->state().positions).norm(), 1e-9) << "component of particle " << first;
  }
  EXPECT_TRUE(compared >= 3 || together.failed());
}

void stiffnessZero(Trial& trial) {
  Particles net = sheet(trial, 4), absent = net;
  // A diagonal across the sheet, of another length than all others.
  net.springs.push_back({0, 15});
  net.stiffness.push_back(0.0);
  net.damping->push_back(0.0);
  net.rest_lengths->push_back(0.3);
  const auto scene = [&](const Particles& particles) {
    Scene built = sceneOf(trial, particles);
    addGravity(built);
    pin(built, {0});
    return built;
  };
  Watched with(trial, scene(net)), without(trial, scene(absent));
  with.step(10);
  without.step(10);
  EXPECT_EQ(with->state().positions, without->state().positions);
}

void longRope(Trial& trial) {
  const int links = underSanitizers() ? 1000 : 10000;
  // 100 m of 10 kg; the load stretches it by some 0.1 m.
  const double k = 1e6 / (100.0 / links), mass = 10.0 / links, load = 100.0;
  Particles net = chain(links, 100.0 / links, kDown, mass, k);
  net.masses.back() = load;
  Scene scene = sceneOf(trial, net);
  addGravity(scene);
  pin(scene, {0});
  // The equations are linear; 1e-8 of the sag is 1e-7 of a link.
  scene.solver.newton_tolerance = 1e-9;
  Watched run(trial, scene);
  // w h = 100 at 10 s: each step leaves 5 % of what is missing, or less.
  run.step(12);
  double sag = 0.0;
  for (int i = 1; i <= links; ++i) sag += (load + mass * (links - i)) * kGravity / k;
  EXPECT_NEAR(-run->state().positions(2, links) - 100.0, sag, 1e-8 * sag);
  EXPECT_FALSE(run.everDegraded());
}

// Conjugate gradients start from what they are given, the last step's velocities; where a reset or
// a teleport has made them wrong, that may cost one iteration more than a start from nothing.
void warmStart(Trial& trial) {
  Scene scene = sceneOf(trial, sheet(trial, 12));
  addGravity(scene);
  pin(scene, {0, 11});
  scene.solver.linear_solver = LinearSolver::kConjugateGradient;
  Watched run(trial, scene), fresh(trial, scene);
  fresh.step();
  run.step(3);
  run->reset();
  const StepReport again = run.step();
  EXPECT_EQ(again.linear_iterations, fresh->totals().linear_iterations);
  EXPECT_EQ(run->state().velocities, fresh->state().velocities);

  const Model& model = run->model();
  StepMatrix matrix(model.pattern);
  const MatrixWeights weights{1.0, trial.h, trial.h * trial.h};
  matrix.setMasses(weights.mass, model.masses);
  for (const auto& effect : model.effects) {
    Probe(*effect, model.start.effects)
        .addDerivatives(model.start.positions, model.start.velocities, weights,
                        Projection::kWhereNeeded, matrix);
  }
  Vectors b = Vectors::Zero(3, model.particleCount()), wrong = b, cold, warm;
  b.row(2) = -kGravity * trial.h * model.masses.transpose();
  wrong.setConstant(60.0);  // m/s, 1 m in a frame
  const double tolerance = scene.solver.linear_tolerance;
  for (const LinearSolver solver : {LinearSolver::kConjugateGradient, LinearSolver::kMultigrid}) {
    SolverOptions options = scene.solver;
    options.linear_solver = solver;
    Workspace workspace(model);
    LinearSystem system(workspace, options);
    const LinearSystem::Result from_nothing = system.solve(matrix, b, tolerance, cold = 0.0 * b);
    const LinearSystem::Result from_wrong = system.solve(matrix, b, tolerance, warm = wrong);
    EXPECT_LE(from_wrong.iterations, from_nothing.iterations + 1) << name(solver);
    EXPECT_LE(from_wrong.residual, tolerance) << name(solver);
    EXPECT_TRUE(from_wrong.converged) << name(solver);
  }
}

void cappedConjugateGradients(Trial& trial) {
  for (const int cap : {1, 5, 20}) {
    Scene scene = sceneOf(trial, randomNet(30, 1e4 * trial.stiffness, 0.8, 5));
    scene.solver.linear_solver = LinearSolver::kConjugateGradient;
    scene.solver.max_linear_iterations = cap;
    Watched run(trial, scene);
    const double start = energy(run->model(), run->state()).elastic;
    run.boundEnergy();
    run.step(3);
    if (run.failed()) return;
    EXPECT_LT(energy(run->model(), run->state()).elastic, start) << "cap " << cap;
    if (cap == 1) {
      EXPECT_TRUE(run.everDegraded()) << "silent";
    }
  }
}

void zeroRightSide(Trial& trial) {
  Watched run(trial, sceneOf(trial, sheet(trial, 5)));
  for (int n = 0; n < 10; ++n) {
    const StepReport report = run.step();
    EXPECT_EQ(report.linear_iterations + report.factorizations, 0u);
    EXPECT_EQ(report.status, StepStatus::kConverged);
  }
  // Spacings of 1/4 m have no rounding errors.
  EXPECT_EQ(maxSpeed(run->state()), 0.0);
}

}  // namespace mass_spring
