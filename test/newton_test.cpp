#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "mass_spring_sim/simulation.h"
#include "problems.h"
#include "schemes/stage_scheme.h"

namespace mass_spring {
namespace {

/// A chain between two pins, stretched to twice its rest length and plucked: tense all through a
/// step that is long enough for several iterations.
Scene tenseScene(Scheme scheme, int max_newton_iterations) {
  Particles chain;
  const std::uint32_t n = 12;
  for (std::uint32_t i = 0; i < n; ++i) {
    chain.positions.emplace_back(0.1 * i, 0.03 * std::sin(1.0 * i), 0.0);
    chain.velocities.emplace_back(0.0, 0.0, i == 0 || i == n - 1 ? 0.0 : 2.0 + std::cos(2.0 * i));
    chain.masses.push_back(0.02);
    if (i == 0) continue;
    chain.springs.push_back({i - 1, i});
    chain.stiffness.push_back(100.0);
  }
  chain.rest_lengths.emplace(n - 1, 0.05);
  Scene scene = netScene(chain, scheme, 20.0);
  pin(scene, {0, n - 1});
  scene.solver.max_newton_iterations = max_newton_iterations;
  scene.solver.newton_tolerance = 1e-14;
  return scene;
}

// e_{k+1} ~ C e_k^2: the logarithms of successive errors double. The sub-steps of the ladder are
// avoided by stepping the scheme itself with a bounded number of iterations.
TEST(Newton, ConvergesQuadraticallyInTension) {
  const auto velocitiesAfter = [](int iterations) {
    const Scene scene = tenseScene(Scheme::kImplicitEuler, iterations);
    const Model model = buildModel(scene);
    Workspace workspace(model);
    StepSystem system(workspace, scene.solver);
    StageScheme stages(workspace, scene.solver, system);
    std::vector<char> pinned(model.particleCount(), 0);
    for (std::uint32_t p : scene.pins[0].particles) pinned[p] = 1;
    State state = model.start;
    const SubstepReport report = stages.advance(
        Scheme::kImplicitEuler, 0.05, Drive{pinned, nullptr, model.start.effects, 0.0}, state);
    EXPECT_EQ(report.projected_springs, 0u);
    return state.velocities;
  };
  const Vectors solution = velocitiesAfter(20);
  std::vector<double> errors;
  for (int k = 1; k <= 8; ++k) {
    const double error = (velocitiesAfter(k) - solution).norm() / solution.norm();
    // From where the quadratic term rules down to where rounding does.
    if (error < 0.3 && error > 1e-13) errors.push_back(error);
  }
  ASSERT_GE(errors.size(), 3u);
  const std::size_t last = errors.size() - 1;
  const double order =
      std::log(errors[last] / errors[last - 1]) / std::log(errors[last - 1] / errors[last - 2]);
  EXPECT_GT(order, 1.7);
  // The last error may already be rounding, which only lowers the order; a higher one than 2 by
  // much would be a comparison with the wrong solution.
  EXPECT_LT(order, 2.6);
}

TEST(LinearImplicitEuler, SolvesEquation19) {
  Particles net = randomNet(15, 100.0, 0.5, 22);
  net.damping.emplace(net.springs.size(), 0.3);
  for (const auto& x : net.positions) net.velocities.push_back(x.cross(Eigen::Vector3d(1, 2, 3)));
  const Scene scene = netScene(net, Scheme::kLinearImplicitEuler, 20.0);
  const double h = 1.0 / 20.0;

  // Eq. 1, 2, 16-19 as the notes write them, with their K = df/dx and D = df/dv, dense.
  const Eigen::Index n = 3 * 15;
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(n, n), k = m, d = m;
  Eigen::VectorXd f = Eigen::VectorXd::Zero(n), v(n);
  for (Eigen::Index i = 0; i < 15; ++i) {
    m.block<3, 3>(3 * i, 3 * i).diagonal().setConstant(net.masses[static_cast<std::size_t>(i)]);
    v.segment<3>(3 * i) = net.velocities[static_cast<std::size_t>(i)];
  }
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  for (std::size_t s = 0; s < net.springs.size(); ++s) {
    const Eigen::Index i = net.springs[s][0], j = net.springs[s][1];
    const Eigen::Vector3d x_ij =
        net.positions[net.springs[s][1]] - net.positions[net.springs[s][0]];
    const double l = x_ij.norm(), l0 = (*net.rest_lengths)[s], ks = net.stiffness[s];
    const Eigen::Vector3d unit = x_ij / l;
    const double kd = (*net.damping)[s];
    const Eigen::Vector3d v_ij = v.segment<3>(3 * j) - v.segment<3>(3 * i);
    const Eigen::Vector3d force = ks * (l - l0) * unit + kd * v_ij.dot(unit) * unit;
    f.segment<3>(3 * i) += force;
    f.segment<3>(3 * j) -= force;
    const Eigen::Matrix3d kii =
        ks * ((l0 / l - 1.0) * identity - l0 / (l * l * l) * x_ij * x_ij.transpose());
    const Eigen::Matrix3d dii = -kd * unit * unit.transpose();
    for (auto [matrix, block] : {std::pair(&k, &kii), std::pair(&d, &dii)}) {
      matrix->block<3, 3>(3 * i, 3 * i) += *block;
      matrix->block<3, 3>(3 * j, 3 * j) += *block;
      matrix->block<3, 3>(3 * i, 3 * j) -= *block;
      matrix->block<3, 3>(3 * j, 3 * i) -= *block;
    }
  }
  const Eigen::VectorXd expected = (m - h * d - h * h * k).ldlt().solve(m * v + h * f - h * d * v);

  Simulation simulation(scene);
  ASSERT_EQ(simulation.step().projected_springs, 0u);
  const Vectors& actual = simulation.state().velocities;
  // 1e-10: two direct solutions of a system with a condition number of some 1e4.
  EXPECT_LT((Eigen::Map<const Eigen::VectorXd>(actual.data(), n) - expected).norm(),
            1e-10 * expected.norm());
}

// The linearized step is one Newton iteration: on the way to the solution, not there.
TEST(Newton, GoesOnWhereTheLinearStepStops) {
  Simulation linear(tenseScene(Scheme::kLinearImplicitEuler, 1));
  Simulation full(tenseScene(Scheme::kImplicitEuler, 50));
  linear.step();
  const StepReport report = full.step();
  EXPECT_EQ(report.status, StepStatus::kConverged);
  EXPECT_GT(report.newton_iterations, 2u);
  const Vectors difference = linear.state().velocities - full.state().velocities;
  EXPECT_GT(difference.norm(), 1e-3 * full.state().velocities.norm());
  EXPECT_LT(difference.norm(), 0.5 * full.state().velocities.norm());
}

// Buckling cloth, 1000 times as stiff as usual: projected matrices alone creep, and leave one step
// in four to be redone in parts.
TEST(Newton, EndsOnBucklingCloth) {
  Particles net = byHand(hangingCloth(20, Scheme::kTrBdf2));
  for (double& k : net.stiffness) k *= 1e3;
  for (double& c : *net.damping) c *= std::sqrt(1e3);
  Scene scene = netScene(net, Scheme::kTrBdf2, 60.0);
  scene.effects.gravity = GravityOptions{Eigen::Vector3d(0, 0, -9.81)};
  pin(scene, {0, 19});
  Simulation simulation(scene);
  for (int n = 0; n < 40; ++n) simulation.step();
  EXPECT_LE(simulation.totals().unconverged_steps, 2u);
}

}  // namespace
}  // namespace mass_spring
