#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/simulation.h"
#include "problems.h"
#include "stability_function.h"

// Schemes against answers known in closed form. 1e-12 is room for some hundred roundings of
// numbers of size 1 (2e-16 each).
namespace mass_spring {
namespace {

class EveryScheme : public testing::TestWithParam<Scheme> {};
class EulersImplicitSchemes : public testing::TestWithParam<Scheme> {};
INSTANTIATE_TEST_SUITE_P(Schemes, EveryScheme, testing::ValuesIn(allSchemes()), schemeName);
INSTANTIATE_TEST_SUITE_P(Schemes, EulersImplicitSchemes,
                         testing::Values(Scheme::kLinearImplicitEuler, Scheme::kImplicitEuler),
                         schemeName);

double displacement(const Simulation& simulation, const Oscillator& oscillator) {
  return simulation.state().positions(0, 1) - oscillator.rest_length;
}

// x_n = x0 + n h v0 + g h^2 n(n+1)/2 with the new velocities, n(n-1)/2 with the old ones; from the
// second order on the parabola itself, n^2/2.
TEST_P(EveryScheme, FreeFall) {
  Particles one;
  one.positions = {Eigen::Vector3d(0.1, 0.2, 0.3)};
  one.velocities = {Eigen::Vector3d(1.0, -0.5, 2.0)};
  one.masses = {0.7};
  Scene scene = netScene(one, GetParam(), 50.0);
  const Eigen::Vector3d g(0.3, 0.0, -9.81);
  scene.effects.gravity = GravityOptions{g};
  Simulation simulation(scene);
  const double h = 1.0 / 50.0;
  const double shift = info(GetParam()).order > 1             ? 0.0
                       : GetParam() == Scheme::kExplicitEuler ? -1.0
                                                              : 1.0;
  for (int n = 1; n <= 40; ++n) {
    ASSERT_EQ(simulation.step().status, StepStatus::kConverged);
    const Eigen::Vector3d expected =
        one.positions[0] + n * h * one.velocities[0] + g * h * h * n * (n + shift) / 2.0;
    EXPECT_LT((simulation.state().positions.col(0) - expected).norm(), 1e-12);
  }
}

// v + i w u is multiplied by a number of modulus 1/sqrt(1 + w^2 h^2) and argument atan(w h).
TEST_P(EulersImplicitSchemes, UndampedSpringLosesEnergyAndPhaseAsPredicted) {
  const Oscillator oscillator;
  const double rate = 30.0, w = oscillator.angularFrequency();
  Simulation simulation(oscillator.scene(GetParam(), rate));
  const double wh = w / rate;
  const std::complex<double> factor = std::polar(1.0 / std::sqrt(1.0 + wh * wh), std::atan(wh));
  std::complex<double> before(0.0, w * oscillator.amplitude);
  double energy_before = energy(simulation.model(), simulation.state()).total();
  for (int n = 0; n < 60; ++n) {
    simulation.step();
    const std::complex<double> after(simulation.state().velocities(0, 1),
                                     w * displacement(simulation, oscillator));
    EXPECT_LT(std::abs(after - factor * before), 1e-12);
    const double energy_after = energy(simulation.model(), simulation.state()).total();
    EXPECT_LT(std::abs(energy_after * (1.0 + wh * wh) / energy_before - 1.0), 1e-12);
    before = after;
    energy_before = energy_after;
  }
}

// (1 + 2 z w h + w^2 h^2) u_{n+1} - (2 + 2 z w h) u_n + u_{n-1} = 0
TEST_P(EulersImplicitSchemes, DampedSpringFollowsItsRecurrence) {
  Oscillator oscillator;
  oscillator.damping = 1.5;
  const double rate = 30.0;
  const double wh = oscillator.angularFrequency() / rate;
  const double zwh = oscillator.dampingRatio() * wh;
  Simulation simulation(oscillator.scene(GetParam(), rate));
  simulation.step();
  // At rest at the start, u_{-1} = u_0.
  double u0 = oscillator.amplitude, u1 = displacement(simulation, oscillator);
  EXPECT_LT(std::abs((1 + 2 * zwh + wh * wh) * u1 - (2 + 2 * zwh) * u0 + u0), 1e-12);
  for (int n = 0; n < 60; ++n) {
    simulation.step();
    const double u2 = displacement(simulation, oscillator);
    EXPECT_LT(std::abs((1 + 2 * zwh + wh * wh) * u2 - (2 + 2 * zwh) * u1 + u0), 1e-12);
    u0 = u1;
    u1 = u2;
  }
}

// cos(w~ h) = 1 - w^2 h^2 / 2, that is u_{n+1} - (2 - w^2 h^2) u_n + u_{n-1} = 0; and
// m v^2 / 2 + k u^2 / 2 - h k u v / 2 stays the same.
TEST(SymplecticEuler, ShiftedFrequencyAndConservedEnergy) {
  const Oscillator oscillator;
  const double rate = 30.0, h = 1.0 / rate, w = oscillator.angularFrequency();
  Simulation simulation(oscillator.scene(Scheme::kSymplecticEuler, rate));
  const double start = 0.5 * oscillator.stiffness * std::pow(oscillator.amplitude, 2);
  double u0 = oscillator.amplitude;
  simulation.step();
  double u1 = displacement(simulation, oscillator);
  for (int n = 0; n < 300; ++n) {
    simulation.step();
    const double u2 = displacement(simulation, oscillator);
    const double v2 = simulation.state().velocities(0, 1);
    EXPECT_LT(std::abs(u2 - (2 - w * w * h * h) * u1 + u0), 1e-12);
    const double modified =
        0.5 * oscillator.mass * v2 * v2 + 0.5 * oscillator.stiffness * u2 * (u2 - h * v2);
    EXPECT_LT(std::abs(modified / start - 1.0), 1e-12);
    u0 = u1;
    u1 = u2;
  }
}

// On a linear problem a scheme is its stability function, damped or not, however long the step.
TEST_P(EveryScheme, IsItsStabilityFunctionOnALinearSpring) {
  for (const double damping : {0.0, 1.5}) {
    for (const double rate : {100.0, 30.0, 2.0, 0.1}) {
      Oscillator oscillator;
      oscillator.damping = damping;
      // Newton starts at x + h v: an amplitude at which that does not turn the spring over.
      const double wh = oscillator.angularFrequency() / rate;
      oscillator.amplitude = std::min(oscillator.amplitude, 0.1 / wh);
      // What grows by 1e30 a step tells nothing more.
      if (!info(GetParam()).implicit && rate < 30.0) continue;
      const auto r =
          stabilityFunction(GetParam(), 1.0 / rate, oscillator.stiffness / oscillator.mass,
                            damping / oscillator.mass);
      if (!r) GTEST_SKIP() << "of several steps: see Bdf2";
      Simulation simulation(oscillator.scene(GetParam(), rate));
      const auto energy_of = [&oscillator](const Eigen::Vector2d& z) {
        return oscillator.stiffness * z[0] * z[0] + oscillator.mass * z[1] * z[1];
      };
      const Eigen::Vector2d start(oscillator.amplitude, 0.0);
      Eigen::Vector2d y = start;
      for (int n = 0; n < 40; ++n) {
        const StepStatus status = simulation.step().status;
        const Eigen::Vector2d expected = *r * y;
        // Explicit Euler gains energy by nature. Its steps say so once that has about doubled.
        const bool grown = energy_of(expected) > 1.5 * energy_of(start);
        ASSERT_EQ(status, grown ? status : StepStatus::kConverged);
        ASSERT_NE(status, StepStatus::kFailed);
        if (std::abs(expected[0]) > oscillator.rest_length) break;  // explicit Euler turned it over
        y = Eigen::Vector2d(displacement(simulation, oscillator),
                            simulation.state().velocities(0, 1));
        // The length of the spring is 1 m with rounding errors of 2e-16 m; forces of k and impulses
        // of h k times that; 100 of each.
        EXPECT_LT(std::abs(y[0] - expected[0]), 1e-12) << "rate " << rate << ", step " << n;
        EXPECT_LT(std::abs(y[1] - expected[1]), 1e-12 * std::max(1.0, wh) * rate)
            << "rate " << rate << ", step " << n;
      }
    }
  }
}

// y_{n+2} = 4/3 y_{n+1} - 1/3 y_n + 2/3 h y'_{n+2}, from the second step on.
TEST(Bdf2, FollowsItsRecurrence) {
  const auto bdf2 = schemeFromName("bdf2");
  ASSERT_TRUE(bdf2);
  for (const double rate : {100.0, 30.0, 2.0, 0.1}) {
    Oscillator oscillator;
    oscillator.damping = 1.5;
    Simulation simulation(oscillator.scene(*bdf2, rate));
    const double h = 1.0 / rate;
    Eigen::Vector2d y0(oscillator.amplitude, 0.0), y1 = y0, y2 = y0;
    for (int n = 1; n < 40; ++n) {
      ASSERT_EQ(simulation.step().status, StepStatus::kConverged);
      y2 = Eigen::Vector2d(displacement(simulation, oscillator),
                           simulation.state().velocities(0, 1));
      if (n > 1) {
        const Eigen::Vector2d slope(
            y2[1], -(oscillator.stiffness * y2[0] + oscillator.damping * y2[1]) / oscillator.mass);
        const Eigen::Vector2d error = y2 - 4.0 / 3.0 * y1 + 1.0 / 3.0 * y0 - 2.0 / 3.0 * h * slope;
        // The second line is a balance of impulses h k u / m, up to 1000 times the velocities.
        EXPECT_LT(std::abs(error[0]), 1e-12 * std::max(1.0, h)) << rate;
        EXPECT_LT(std::abs(error[1]), 1e-12 * std::max(1.0, 100.0 * h)) << rate;
        y0 = y1;
      }
      y1 = y2;
    }
  }
}

// |lambda| = 1 and tan(w~ h / 2) = w h / 2: v + i w u turns by w~ h each step.
TEST(ImplicitMidpoint, KeepsTheAmplitudeAndShiftsTheFrequency) {
  const auto midpoint = schemeFromName("implicit_midpoint");
  ASSERT_TRUE(midpoint);
  const Oscillator oscillator;
  const double rate = 30.0, w = oscillator.angularFrequency();
  const std::complex<double> turn = std::polar(1.0, 2.0 * std::atan(0.5 * w / rate));
  Simulation simulation(oscillator.scene(*midpoint, rate));
  std::complex<double> before(0.0, w * oscillator.amplitude);
  for (int n = 0; n < 60; ++n) {
    simulation.step();
    const std::complex<double> after(simulation.state().velocities(0, 1),
                                     w * displacement(simulation, oscillator));
    EXPECT_LT(std::abs(after - turn * before), 1e-12);
    EXPECT_LT(std::abs(std::abs(after) - w * oscillator.amplitude), 1e-12);
    before = after;
  }
}

// Two bodies swing about their center of mass with w^2 = k / mu, mu = m1 m2 / (m1 + m2).
TEST_P(EveryScheme, TwoBodiesSwingWithTheReducedMass) {
  Particles pair;
  pair.positions = {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0, 1.2, 0)};
  pair.velocities = {Eigen::Vector3d(0.1, 0.2, 0.0), Eigen::Vector3d(0.1, 0.2, 0.0)};
  pair.masses = {0.2, 0.5};
  pair.springs = {{0, 1}};
  pair.stiffness = {30.0};
  pair.rest_lengths = {{1.0}};
  Simulation simulation(netScene(pair, GetParam(), 40.0));
  const double h = 1.0 / 40.0, mu = 0.2 * 0.5 / 0.7;
  const auto r = stabilityFunction(GetParam(), h, 30.0 / mu, 0.0);
  const Eigen::Vector3d center = (0.2 * pair.positions[0] + 0.5 * pair.positions[1]) / 0.7;
  Eigen::Vector2d y(0.2, 0.0);  // stretch and its rate
  for (int n = 1; n < 100; ++n) {
    simulation.step();
    const Vectors& x = simulation.state().positions;
    const Vectors& v = simulation.state().velocities;
    if (r) y = *r * y;
    if (r && y.norm() < 10.0) {  // explicit Euler leaves what is linear: the ends meet
      // 1e-11: some hundred steps of 1e-13, relative to amplitudes of up to 10.
      EXPECT_LT(std::abs((x.col(1) - x.col(0)).y() - 1.0 - y[0]), 1e-11) << n;
      EXPECT_LT(std::abs((v.col(1) - v.col(0)).y() - y[1]), 1e-10) << n;
    }
    const Eigen::Vector3d now = (0.2 * x.col(0) + 0.5 * x.col(1)) / 0.7;
    EXPECT_LT((now - center - n * h * pair.velocities[0]).norm(), 1e-12);
    if (HasFailure() || y.norm() >= 10.0) return;
  }
}

// Internal forces are equal and opposite, so every scheme keeps the momentum. 1e-11: rounding
// of forces some 100 times the momentum, over 100 steps.
TEST_P(EveryScheme, KeepsLinearMomentum) {
  Particles net = randomNet(30, 20.0, 0.8, 7);
  net.velocities.assign(30, Eigen::Vector3d(0.3, -0.2, 0.1));
  net.damping.emplace(net.springs.size(), 0.01);
  Simulation simulation(netScene(net, GetParam(), 200.0));
  const auto momentum = [&] {
    return Eigen::Vector3d(simulation.state().velocities * simulation.model().masses);
  };
  const Eigen::Vector3d start = momentum();
  for (int step = 0; step < 100; ++step) simulation.step();
  EXPECT_LT((momentum() - start).norm(), 1e-11 * start.norm());
  EXPECT_GT(energy(simulation.model(), simulation.state()).elastic, 0.0);
}

class KeepsAngularMomentum : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Schemes, KeepsAngularMomentum,
                         testing::Values("symplectic_euler", "implicit_midpoint"),
                         [](const auto& p) { return std::string(p.param); });

// Symplectic Euler: x_{n+1} x v_{n+1} = x_n x v_{n+1}, and the forces at x_n have no torque there.
// Midpoint: the same at the middle of the step.
TEST_P(KeepsAngularMomentum, OfASpinningNet) {
  const auto scheme = schemeFromName(GetParam());
  ASSERT_TRUE(scheme);
  Particles net = randomNet(30, 20.0, 0.8, 8);
  for (const auto& x : net.positions) {
    net.velocities.push_back(Eigen::Vector3d(0.2, -0.3, 0.5).cross(x));
  }
  Scene scene = netScene(net, *scheme, 200.0);
  scene.solver.newton_tolerance = 1e-13;  // what is left of the equations is left of the momentum
  Simulation simulation(scene);
  const auto angularMomentum = [&] {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (Eigen::Index i = 0; i < 30; ++i) {
      const Eigen::Vector3d x = simulation.state().positions.col(i);
      const Eigen::Vector3d v = simulation.state().velocities.col(i);
      sum += simulation.model().masses[i] * x.cross(v);
    }
    return sum;
  };
  const Eigen::Vector3d start = angularMomentum();
  for (int step = 0; step < 100; ++step) {
    ASSERT_EQ(simulation.step().status, StepStatus::kConverged);
  }
  // As for linear momentum.
  EXPECT_LT((angularMomentum() - start).norm(), 1e-11 * start.norm());
}

// U_{n+1} + |v_{n+1} - v_n|^2_M / 2 <= U_n + |v_n|^2_M / 2, from a scrambled start with springs
// far compressed and far stretched, at steps long for the stiffness (w h up to some 60).
TEST(ImplicitEuler, NeverGainsEnergy) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Particles net = randomNet(40, 1e4, 1.0, seed);
    std::swap(net.positions[3], net.positions[30]);
    std::swap(net.positions[5], net.positions[11]);
    Simulation simulation(netScene(net, Scheme::kImplicitEuler, 30.0));
    for (int step = 0; step < 60; ++step) {
      const State before = simulation.state();
      const Energy start = energy(simulation.model(), before);
      ASSERT_NE(simulation.step().status, StepStatus::kFailed);
      State change = simulation.state();
      change.velocities -= before.velocities;
      const double end = energy(simulation.model(), simulation.state()).elastic +
                         energy(simulation.model(), change).kinetic;
      // 1e-9: Newton stops at a residual of 1e-6 of a rest length, whose energy is second order.
      EXPECT_LE(end, start.total() * (1.0 + 1e-9)) << "seed " << seed << ", step " << step;
    }
  }
}

}  // namespace
}  // namespace mass_spring
