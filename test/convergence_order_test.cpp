#include <gtest/gtest.h>

#include <cmath>

#include "mass_spring_sim/simulation.h"
#include "problems.h"

// Halving h divides the error by 2^p. A wrongly weighted term still converges, only at another
// rate, hence a band with two sides; the next term of the expansion leaves O(h).
namespace mass_spring {
namespace {

class ConvergenceOrder : public testing::TestWithParam<Scheme> {
 protected:
  int order() const { return info(GetParam()).order; }
};
INSTANTIATE_TEST_SUITE_P(Schemes, ConvergenceOrder, testing::ValuesIn(allSchemes()), schemeName);

// Against the exact solution, so that it is also the right limit.
class OrderOfOscillators : public ConvergenceOrder {
 protected:
  /// @param scene  at some rate [Hz], with the oscillator
  /// @param displacement  of a particle in a state [m]
  template <typename MakeScene, typename Displacement>
  void expectOrder(const MakeScene& scene, const Displacement& displacement) const {
    const auto error = [&](double rate) {
      Scene fine = scene(rate);
      fine.solver.newton_tolerance = 1e-13;
      Simulation simulation(fine);
      while (simulation.state().time < 1.0) simulation.step();
      return std::abs(displacement(simulation.state()) -
                      oscillator_.displacement(simulation.state().time));
    };
    // Where the leading term rules, and rounding is far: w h = 0.006, 0.02, 0.04, 0.09.
    const double coarse[] = {0.0, 2000.0, 500.0, 300.0, 128.0};
    const double rate = coarse[order()];
    EXPECT_GT(error(2.0 * rate), 1e-10);  // not a comparison of zeros
    EXPECT_NEAR(std::log2(error(rate) / error(2.0 * rate)), order(), 0.1);
  }

  /// A particle that swings about where it has sunk into a cushion by its weight, in air: with the
  /// same frequency, damped alike. It never leaves the cushion.
  Scene onCushion(double rate) {
    oscillator_.amplitude = 0.5 * sunk();
    Particles particle;
    particle.positions = {{0.0, 0.0, kThickness - sunk() + oscillator_.amplitude}};
    particle.masses = {oscillator_.mass};
    Scene scene = netScene(std::move(particle), GetParam(), rate);
    scene.effects.gravity = GravityOptions{Eigen::Vector3d(0.0, 0.0, -kGravity)};
    scene.effects.air_drag = AirDragOptions{oscillator_.damping};
    return scene;
  }
  double above(const State& state) const { return state.positions(2, 0) - kThickness + sunk(); }
  double sunk() const { return oscillator_.mass * kGravity / oscillator_.stiffness; }  // m

  static constexpr double kThickness = 0.2;  // m
  Oscillator oscillator_;
};
INSTANTIATE_TEST_SUITE_P(Schemes, OrderOfOscillators, testing::ValuesIn(allSchemes()), schemeName);

TEST_P(OrderOfOscillators, OnADampedSpring) {
  oscillator_.damping = 0.4;
  expectOrder([&](double rate) { return oscillator_.scene(GetParam(), rate); },
              [&](const State& state) { return state.positions(0, 1) - oscillator_.rest_length; });
}

TEST_P(OrderOfOscillators, OnAPlaneInAir) {
  oscillator_.damping = 0.4;
  const auto scene = [&](double rate) {
    Scene cushion = onCushion(rate);
    ContactOptions& contact = cushion.effects.contact.emplace();
    contact.stiffness = oscillator_.stiffness;
    contact.thickness = kThickness;
    contact.shapes = {{"floor", Plane{{0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}}}};
    return cushion;
  };
  expectOrder(scene, [&](const State& state) { return above(state); });
}

TEST_P(OrderOfOscillators, OnAnotherSegmentInAir) {
  oscillator_.damping = 0.4;
  const auto scene = [&](double rate) {
    Scene cushion = onCushion(rate);
    Particles beam;
    beam.positions = {{-0.5, 0.0, 0.0}, {0.5, 0.0, 0.0}};
    beam.velocities.assign(2, Eigen::Vector3d::Zero());
    beam.masses = {1.0, 1.0};
    beam.springs = {{0, 1}};
    beam.stiffness = {1.0};
    cushion.objects.push_back({"under", {}, beam});
    cushion.pins = {{"held", "under", {0, 1}}};
    cushion.effects.self_collision = SelfCollisionOptions{kThickness, oscillator_.stiffness};
    return cushion;
  };
  expectOrder(scene, [&](const State& state) { return above(state); });
}

// A swinging, stretching, damped net under gravity, pulled along by a pin: x_h - x_{h/2} shrinks
// like the error. The pin changes its course every 1/8 s, at the end of a step at each of the step
// sizes: the path is the same.
class SwingingNet {
 public:
  SwingingNet(Scheme scheme, bool damped) : scheme_(scheme), net_(randomNet(12, 30.0, 0.9, 3)) {
    if (damped) net_.damping.emplace(net_.springs.size(), 0.02);
  }

  Vectors end(double rate) const {
    Scene scene = netScene(net_, scheme_, rate);
    scene.solver.newton_tolerance = 1e-13;
    scene.solver.linear_tolerance = 1e-13;
    scene.effects.gravity = GravityOptions{Eigen::Vector3d(0, 0, -9.81)};
    pin(scene, {0, 1});
    Simulation simulation(scene);
    PinCommand move;
    move.action = PinCommand::Action::kMove;
    move.name = "hold";
    const Eigen::Vector3d start = simulation.pins().all().at("hold").target.position;
    for (int step = 1; step <= static_cast<int>(0.25 * rate); ++step) {
      const double t = step / rate;
      move.target.position = start + std::min(t, 0.125) * Eigen::Vector3d(1.0, 0.0, 0.5) +
                             std::max(t - 0.125, 0.0) * Eigen::Vector3d(0.0, 2.0, 0.0);
      simulation.apply(move);
      EXPECT_EQ(simulation.step().status, StepStatus::kConverged) << "step " << step;
    }
    return simulation.state().positions;
  }

  /// @param rate  Hz, the coarsest of three that double
  void expectOrder(int order, double rate) const {
    const Vectors coarse = end(rate), middle = end(2.0 * rate), fine = end(4.0 * rate);
    const double difference = (middle - fine).norm();
    EXPECT_GT(difference, 1e-9);  // Newton's tolerance is far below
    // 0.1: what the next term of the expansion leaves at these steps.
    EXPECT_NEAR(std::log2((coarse - middle).norm() / difference), order, 0.1);
  }

 private:
  Scheme scheme_;
  Particles net_;
};

// w h up to 0.02, 0.1, 0.2, 0.4 in the stiffest mode.
constexpr double kCoarsestRate[] = {0.0, 16384.0, 2048.0, 1024.0, 512.0};

TEST_P(ConvergenceOrder, OfASwingingNetThatAPinPulls) {
  SwingingNet(GetParam(), false).expectOrder(order(), kCoarsestRate[order()]);
}

TEST_P(ConvergenceOrder, OfADampedSwingingNetThatAPinPulls) {
  SwingingNet(GetParam(), true).expectOrder(order(), kCoarsestRate[order()]);
}

}  // namespace
}  // namespace mass_spring
