#include <gtest/gtest.h>

#include <cmath>

#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/simulation.h"
#include "problems.h"
#include "stability_function.h"

// Chains, ropes and a rotating pair against answers known in closed form.
namespace mass_spring {
namespace {

class EveryChain : public testing::TestWithParam<Scheme> {};
class ImplicitChains : public testing::TestWithParam<Scheme> {};
INSTANTIATE_TEST_SUITE_P(Schemes, EveryChain, testing::ValuesIn(summingSchemes()), schemeName);
INSTANTIATE_TEST_SUITE_P(Schemes, ImplicitChains, testing::ValuesIn(solvingSchemes()), schemeName);

/// n free particles of 0.02 kg between two walls, springs of 50 N/m stretched to 0.1 m from 0.06 m.
struct WalledChain {
  static constexpr int n = 7;
  static constexpr double mass = 0.02, stiffness = 50.0, rest = 0.06, spacing = 0.1;

  Scene scene(Scheme scheme, double rate, int mode, const Eigen::Vector3d& displacement) const {
    Particles net = chain(n + 1, spacing, Eigen::Vector3d::UnitX(), mass, stiffness);
    net.rest_lengths.emplace(net.springs.size(), rest);
    for (int i = 1; i <= n; ++i) {
      net.positions[static_cast<std::size_t>(i)] += shape(mode, i) * displacement;
    }
    Scene built = netScene(net, scheme, rate);
    pin(built, {0, n + 1});
    return built;
  }
  static double shape(int mode, int i) { return std::sin(mode * M_PI * i / (n + 1)); }
  /// Square of w_j = 2 sqrt(k / m) sin(j pi / (2 (n + 1))).
  static double squaredFrequency(double k, int mode) {
    const double s = 2.0 * std::sin(mode * M_PI / (2.0 * (n + 1)));
    return k / mass * s * s;
  }
};

/// Lets a mode swing along `axis` and compares each particle with the stability function at the
/// frequency expected.
void followMode(Scheme scheme, int mode, const Eigen::Vector3d& displacement, double w2,
                double tolerance) {
  // Explicit Euler lets everything grow; not by much in 50 steps of 0.5 ms.
  const double rate = scheme == Scheme::kExplicitEuler ? 2000.0 : 200.0;
  const auto r = stabilityFunction(scheme, 1.0 / rate, w2, 0.0);
  if (!r) GTEST_SKIP() << "of several steps";
  Simulation simulation(WalledChain().scene(scheme, rate, mode, displacement));
  Eigen::Vector2d y(1.0, 0.0);
  for (int step = 0; step < 50; ++step) {
    ASSERT_EQ(simulation.step().status, StepStatus::kConverged);
    y = *r * y;
    for (int i = 1; i <= WalledChain::n; ++i) {
      const Eigen::Vector3d expected = Eigen::Vector3d(i * WalledChain::spacing, 0, 0) +
                                       y[0] * WalledChain::shape(mode, i) * displacement;
      // Along the displacement: across it, springs that turn by e/a shorten by half its square.
      const Eigen::Vector3d error = simulation.state().positions.col(i) - expected;
      EXPECT_LT(std::abs(error.dot(displacement)), tolerance * displacement.squaredNorm())
          << "mode " << mode << ", step " << step << ", particle " << i;
    }
  }
}

// Along the chain all is linear: 1e-11 of an amplitude of 1 cm are a thousand roundings of 1 m.
TEST_P(EveryChain, LongitudinalModesOfAChain) {
  for (const int mode : {1, 3, 7}) {
    followMode(GetParam(), mode, Eigen::Vector3d(0.01, 0, 0),
               WalledChain::squaredFrequency(WalledChain::stiffness, mode), 1e-11);
    if (HasFailure() || IsSkipped()) return;
  }
}

// Across it, T/a stands for k, with the tension T at the stretched spacing a, for small amplitudes
// e: the next term is (e/a)^2 = 1e-8, and rounding 1e-16/e = 1e-11.
TEST_P(EveryChain, TransverseModesOfAChain) {
  const double tension = WalledChain::stiffness * (WalledChain::spacing - WalledChain::rest);
  for (const int mode : {1, 3, 7}) {
    followMode(GetParam(), mode, Eigen::Vector3d(0, 0.6e-5, 0.8e-5),
               WalledChain::squaredFrequency(tension / WalledChain::spacing, mode), 1e-6);
    if (HasFailure() || IsSkipped()) return;
  }
}

/// A chain of n particles below a pin, each spring longer by the weight below it.
Scene hangingChain(Scheme scheme, double rate, bool at_rest) {
  const int n = 12;
  const double mass = 0.05, stiffness = 200.0;
  Particles net = chain(n, 0.1, -Eigen::Vector3d::UnitZ(), mass, stiffness);
  double sag = 0.0;
  for (int i = 1; i <= n && at_rest; ++i) {
    sag += (n - i + 1) * mass * kGravity / stiffness;
    net.positions[static_cast<std::size_t>(i)].z() -= sag;
  }
  Scene scene = netScene(net, scheme, rate);
  pin(scene, {0});
  scene.effects.gravity = GravityOptions{Eigen::Vector3d(0, 0, -kGravity)};
  return scene;
}

/// @param tolerance  m: what the scheme leaves
void expectHangingAtRest(const Simulation& simulation, double tolerance) {
  const Vectors& x = simulation.state().positions;
  for (int i = 1; i <= 12; ++i) {
    const double expected = 0.1 + (12 - i + 1) * 0.05 * kGravity / 200.0;
    EXPECT_NEAR((x.col(i) - x.col(i - 1)).norm(), expected, tolerance) << "spring " << i;
  }
}

// Spring i of a hanging chain is longer by (N - i + 1) m g / k: every scheme rests there.
TEST_P(EveryChain, HangingChainStaysAtRest) {
  Simulation simulation(hangingChain(GetParam(), 2000.0, true));
  for (int step = 0; step < 100; ++step) simulation.step();
  // Rounding of forces of 6 N, 1e-15 of them per step on 0.05 kg; explicit Euler lets it grow.
  expectHangingAtRest(simulation, 1e-12);
  EXPECT_LT(maxSpeed(simulation.state()), 1e-10);
}

// ... and those that damp what is stiff get there, from springs at their rest lengths.
TEST_P(ImplicitChains, HangingChainStretchesByTheWeightBelow) {
  if (info(GetParam()).name == "implicit_midpoint") GTEST_SKIP() << "swings for ever";
  // The modes, w = 7.9 to 126 rad/s, are far above what a step of 1 s resolves.
  Simulation simulation(hangingChain(GetParam(), 1.0, false));
  for (int step = 0; step < 100; ++step) simulation.step();
  // 1e-9: the linear systems are solved to 1e-15, the springs' lengths are differences.
  expectHangingAtRest(simulation, 1e-9);
}

// Two masses m about each other at l = k L / (k - m w^2 / 2).
class RotatingPair {
 public:
  explicit RotatingPair(Scheme scheme) : simulation_(scene(scheme)) {
    momentum_ = angularMomentum();
    for (int step = 0; step < 1000 && good_; ++step) {
      good_ = simulation_.step().status == StepStatus::kConverged;
      const Vectors& x = simulation_.state().positions;
      const double length = (x.col(1) - x.col(0)).norm();
      error_ = std::max(error_, std::abs(length - length_));
    }
  }
  bool good() const { return good_; }
  double lengthError() const { return error_; }                                // m, the largest
  double momentumGain() const { return angularMomentum() / momentum_ - 1.0; }  // relative

 private:
  static constexpr double mass_ = 0.1, stiffness_ = 500.0, rest_ = 0.5, omega_ = 20.0;
  static constexpr double length_ =
      stiffness_ * rest_ / (stiffness_ - 0.5 * mass_ * omega_ * omega_);

  static Scene scene(Scheme scheme) {
    Particles pair;
    pair.positions = {Eigen::Vector3d(-0.5 * length_, 0, 0), Eigen::Vector3d(0.5 * length_, 0, 0)};
    pair.velocities = {Eigen::Vector3d(0, -0.5 * length_ * omega_, 0),
                       Eigen::Vector3d(0, 0.5 * length_ * omega_, 0)};
    pair.masses = {mass_, mass_};
    pair.springs = {{0, 1}};
    pair.stiffness = {stiffness_};
    pair.rest_lengths = {{rest_}};
    Scene built = netScene(pair, scheme, 2000.0);
    built.solver.newton_tolerance = 1e-12;
    return built;
  }
  double angularMomentum() const {
    const Vectors &x = simulation_.state().positions, &v = simulation_.state().velocities;
    const Eigen::Vector3d first = x.col(0), second = x.col(1);
    return mass_ *
           (first.cross(Eigen::Vector3d(v.col(0))) + second.cross(Eigen::Vector3d(v.col(1)))).z();
  }

  Simulation simulation_;
  double momentum_ = 0.0, error_ = 0.0;
  bool good_ = true;
};

TEST_P(EveryChain, RotatingPairKeepsItsLength) {
  const RotatingPair pair(GetParam());
  ASSERT_TRUE(pair.good());
  // w h = 0.01, after 1.6 turns: errors of (w h)^p times a few, first order ones spiral.
  const double expected[] = {0.0, 0.2, 1e-4, 1e-5, 1e-8};
  EXPECT_LT(pair.lengthError(), expected[info(GetParam()).order]);
}

TEST(RotatingPairs, SpinDownWithImplicitEulerAndNotWithMidpoint) {
  const double euler = RotatingPair(Scheme::kImplicitEuler).momentumGain();
  // |v| falls by 1/sqrt(1 + w^2 h^2) a step, to first order as if the spring were rigid.
  EXPECT_LT(euler, -0.02);
  EXPECT_GT(euler, -0.2);
  const auto midpoint = schemeFromName("implicit_midpoint");
  ASSERT_TRUE(midpoint);
  EXPECT_LT(std::abs(RotatingPair(*midpoint).momentumGain()), 1e-10);  // Newton's 1e-12, 1000 steps
}

// tan(angle of spring i) = W_i / H: the horizontal pull is the same in all springs, and the
// vertical one grows by the weight of each particle.
TEST_P(ImplicitChains, RopeAtRestIsACatenary) {
  if (info(GetParam()).name == "implicit_midpoint") GTEST_SKIP() << "swings for ever";
  const int links = 16;
  const double mass = 0.02, stiffness = 2000.0, spacing = 0.1;
  Particles net = chain(links, spacing, Eigen::Vector3d::UnitX(), mass, stiffness);
  net.rest_lengths.emplace(net.springs.size(), 1.1 * spacing);
  for (int i = 1; i < links; ++i) {  // sagging, so that it is not compressed at the start
    net.positions[static_cast<std::size_t>(i)].z() = -0.6 * std::sin(M_PI * i / links);
  }
  net.damping.emplace(net.springs.size(), 2.0);
  Scene scene = netScene(net, GetParam(), 2.0);
  scene.solver.newton_tolerance = 1e-12;
  scene.effects.gravity = GravityOptions{Eigen::Vector3d(0, 0, -kGravity)};
  pin(scene, {0, links});
  Simulation simulation(scene);
  for (int step = 0; step < 600; ++step) simulation.step();
  ASSERT_LT(maxSpeed(simulation.state()), 1e-9) << "not at rest";
  const auto pull = [&](int spring) {
    const Spring& s = simulation.model().springs[static_cast<std::size_t>(spring)];
    const Vectors& x = simulation.state().positions;
    const Eigen::Vector3d d = x.col(s.j) - x.col(s.i);
    return Eigen::Vector3d(s.stiffness * (1.0 - s.rest_length / d.norm()) * d);
  };
  const double horizontal = pull(0).x();
  EXPECT_GT(horizontal, 0.1);
  for (int spring = 0; spring < links; ++spring) {
    // Half the rope's weight hangs on each side of its middle.
    const double weight = (spring - 0.5 * (links - 1)) * mass * kGravity;
    // 1e-8 N: 2000 N/m times the 1e-12 m to which Newton solves, and the rest of the swing.
    EXPECT_NEAR(pull(spring).x(), horizontal, 1e-8) << "spring " << spring;
    EXPECT_NEAR(pull(spring).z() / pull(spring).x(), weight / horizontal, 1e-7)
        << "spring " << spring;
  }
}

// A pulse runs along a chain at a sqrt(k/m).
TEST_P(EveryChain, WavesTravelAtTheirSpeed) {
  if (GetParam() == Scheme::kExplicitEuler) GTEST_SKIP() << "unstable without damping";
  const int links = 160;
  const double spacing = 0.05, mass = 0.01, stiffness = 400.0;
  const double speed = spacing * std::sqrt(stiffness / mass);  // 10 m/s
  Particles net = chain(links, spacing, Eigen::Vector3d::UnitX(), mass, stiffness);
  // u = A exp(-(s/width)^2), moving to the right: u' = -c du/dx.
  const double width = 12.0 * spacing, start = 40.0 * spacing, amplitude = 1e-3;
  for (std::size_t i = 0; i < net.positions.size(); ++i) {
    const double s = (net.positions[i].x() - start) / width;
    const double u = amplitude * std::exp(-s * s);
    net.positions[i].x() += u;
    net.velocities[i].x() = speed * 2.0 * s / width * u;
  }
  // c h / a = 0.1
  const double rate = 10.0 * speed / spacing;
  Scene scene = netScene(net, GetParam(), rate);
  pin(scene, {0, links});
  Simulation simulation(scene);
  for (int step = 0; step < 600; ++step) {
    ASSERT_EQ(simulation.step().status, StepStatus::kConverged);
  }
  int top = 1;
  const auto u = [&](int i) { return simulation.state().positions(0, i) - i * spacing; };
  for (int i = 1; i < links; ++i) top = u(i) > u(top) ? i : top;
  // The vertex of the parabola through the three highest.
  const double left = u(top - 1), middle = u(top), right = u(top + 1);
  const double vertex = top + 0.5 * (left - right) / (left - 2.0 * middle + right);
  const double traveled = vertex * spacing - start;
  // Waves of length 2 pi width / sqrt(2) lag by (q a)^2 / 24 = 6e-4, shorter ones more, and the
  // schemes by (q c h)^2 / 12 = 1e-5: 0.3 %.
  EXPECT_NEAR(traveled / (speed * simulation.state().time), 1.0, 3e-3);
}

}  // namespace
}  // namespace mass_spring
