#include <gtest/gtest.h>

#include <cmath>

#include "mass_spring_sim/simulation.h"
#include "problems.h"

// Halving h divides the error by 2^p. A wrongly weighted term still converges, only at another
// rate, hence a band with two sides; the next term of the expansion leaves O(h).
namespace mass_spring {
namespace {

std::string schemeName(const testing::TestParamInfo<Scheme>& p) { return info(p.param).name; }

class ConvergenceOrder : public testing::TestWithParam<Scheme> {};
INSTANTIATE_TEST_SUITE_P(Schemes, ConvergenceOrder,
                         testing::Values(Scheme::kExplicitEuler, Scheme::kSymplecticEuler,
                                         Scheme::kLinearImplicitEuler, Scheme::kImplicitEuler),
                         schemeName);

// Against the exact solution, so that it is also the right limit.
TEST_P(ConvergenceOrder, OfADampedSpring) {
  Oscillator oscillator;
  oscillator.damping = 0.4;
  const auto error = [&](double rate) {
    Simulation simulation(oscillator.scene(GetParam(), rate));
    while (simulation.state().time < 1.0) simulation.step();
    return std::abs(simulation.state().positions(0, 1) - oscillator.rest_length -
                    oscillator.displacement(simulation.state().time));
  };
  const double order = std::log2(error(2000.0) / error(4000.0));
  EXPECT_GT(error(4000.0), 1e-7);  // not a comparison of zeros
  EXPECT_NEAR(order, info(GetParam()).order, 0.1);
}

// A swinging, stretching, damped net under gravity: x_h - x_{h/2} shrinks like the error.
TEST_P(ConvergenceOrder, OfASwingingNet) {
  Particles net = randomNet(12, 30.0, 0.9, 3);
  net.damping.emplace(net.springs.size(), 0.02);
  const auto end = [&](double rate) {
    Scene scene = netScene(net, GetParam(), rate);
    scene.solver.newton_tolerance = 1e-12;
    scene.effects.gravity = GravityOptions{Eigen::Vector3d(0, 0, -9.81)};
    pin(scene, {0, 1});
    Simulation simulation(scene);
    while (simulation.state().time < 0.25) simulation.step();
    return simulation.state().positions;
  };
  const Vectors coarse = end(16000.0), middle = end(32000.0), fine = end(64000.0);
  const double difference = (middle - fine).norm();
  EXPECT_GT(difference, 1e-7);
  // 0.1: what the next term of the expansion leaves at these steps.
  EXPECT_NEAR(std::log2((coarse - middle).norm() / difference), info(GetParam()).order, 0.1);
}

}  // namespace
}  // namespace mass_spring
