#include "stepper.h"

#include <gtest/gtest.h>

#include <cmath>

#include "effects/effect.h"
#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/simulation.h"
#include "problems.h"

// Steps that go wrong: never silent, never not finite.
namespace mass_spring {
namespace {

TEST(Stepper, ExplicitBlowUpFailsAndKeepsTheLastGoodState) {
  Simulation simulation(Oscillator{0.001, 1e6}.scene(Scheme::kExplicitEuler, 10.0));
  StepReport report;
  State before;
  int steps = 0;
  do {
    before = simulation.state();
    report = simulation.step();
    // The error grows by w h = 3162 a step: 1e308 is reached within 100.
    ASSERT_LT(++steps, 200);
  } while (report.status == StepStatus::kConverged);
  EXPECT_EQ(report.status, StepStatus::kFailed);
  EXPECT_NE(report.message.find("object net, particle 1"), std::string::npos) << report.message;
  EXPECT_EQ(simulation.state().step, before.step);
  EXPECT_EQ(simulation.state().positions, before.positions);
  EXPECT_EQ(simulation.state().velocities, before.velocities);
  EXPECT_TRUE(before.positions.allFinite());
  EXPECT_EQ(simulation.totals().unconverged_steps, 1u);
}

// Conjugate gradients stopped after one iteration: said, and the energy still falls.
TEST(Stepper, CappedSolverIsDegradedNotSilent) {
  for (Scheme scheme : {Scheme::kLinearImplicitEuler, Scheme::kImplicitEuler}) {
    Scene scene = netScene(randomNet(60, 1e4, 0.8, 5), scheme, 30.0);
    scene.solver.linear_solver = LinearSolver::kConjugateGradient;
    scene.solver.max_linear_iterations = 1;
    scene.solver.max_newton_iterations = 2;
    Simulation simulation(scene);
    const double start = energy(simulation.model(), simulation.state()).total();
    for (int n = 0; n < 10; ++n) {
      const StepReport report = simulation.step();
      EXPECT_EQ(report.status, StepStatus::kDegraded);
      EXPECT_FALSE(report.message.empty());
      EXPECT_GT(report.rejected, 0u);
      EXPECT_LE(energy(simulation.model(), simulation.state()).total(), start);
    }
    EXPECT_EQ(simulation.totals().unconverged_steps, 10u);
  }
}

TEST(Stepper, ConvergedMeansNewtonsToleranceWasReached) {
  Scene scene = netScene(randomNet(30, 1e3, 0.8, 6), Scheme::kImplicitEuler, 60.0);
  Simulation simulation(scene);
  for (int n = 0; n < 30; ++n) {
    const StepReport report = simulation.step();
    ASSERT_EQ(report.status, StepStatus::kConverged);
    EXPECT_LE(report.residual, scene.solver.newton_tolerance);
  }
}

// A force so large that its effect is no number: not ignored, not accepted.
TEST(Stepper, OverflowingForceFails) {
  for (const SchemeInfo& scheme : schemes()) {
    Scene scene = netScene(randomNet(5, 10.0, 1.0, 2), scheme.scheme, 50.0);
    std::get<Particles>(scene.objects[0].shape).masses[3] = 1e-9;
    scene.limits.max_force = 1e308;
    Simulation simulation(scene);
    ForceCommand push;
    push.particles = {3};
    push.forces = {Eigen::Vector3d(0, 0, 1e308)};
    ASSERT_TRUE(simulation.apply(push).accepted());
    const StepReport report = simulation.step();
    EXPECT_EQ(report.status, StepStatus::kFailed) << scheme.name;
    // The later stages of rk4, and one spring after the other, have passed it on to the neighbors.
    const bool passed_on = scheme.scheme == Scheme::kRk4 || scheme.scheme == Scheme::kXpbd;
    const char* where = passed_on ? "object net, particle" : "particle 3";
    EXPECT_NE(report.message.find(where), std::string::npos) << report.message;
    EXPECT_EQ(simulation.state().positions, simulation.model().start.positions);
  }
}

/// Adds no force, and notes the size of each sub-step.
class SubstepSizes : public Effect, public SweptEffect {
 public:
  explicit SubstepSizes(std::vector<double>& sizes)
      : Effect(Traits{{"substep_sizes"}}), sizes_(sizes) {}
  std::unique_ptr<Scratch> makeScratch(ThreadPool&) const override {
    return std::make_unique<Scratch>();
  }
  void beginSubstep(Scratch&, const Vectors&, const Vectors&, double h) const override {
    sizes_.push_back(h);
  }
  bool endSubstep(Scratch&, const Vectors&) const override { return false; }
  void add(const Point&, Scratch*, const Sums&) const override {}
  std::uint32_t linearize(const Point&, Scratch*, double, StepMatrix&, Vectors&) const override {
    return 0;
  }

 private:
  std::vector<double>& sizes_;
};

// What is found for one size of a sub-step serves for all of them (SpringRelaxation).
TEST(Stepper, SubstepsHaveTheSameSizeToTheBit) {
  for (const SchemeInfo& scheme : schemes()) {
    Scene scene = Oscillator().scene(scheme.scheme, 70.0);
    scene.solver.substeps = 23;
    Model model = buildModel(scene);
    std::vector<double> sizes;
    model.effects.push_back(std::make_shared<SubstepSizes>(sizes));
    State state = model.start;
    Stepper(model, model.solver).step(1.0 / 70.0, Pins(2), nullptr, state);
    ASSERT_EQ(sizes.size(), 23u) << scheme.name;
    for (const double size : sizes) EXPECT_EQ(size, 1.0 / 70.0 / 23) << scheme.name;
  }
}

// Particles on one another have no direction between them; they part to their rest length.
TEST(Stepper, CoincidentParticlesPart) {
  Particles pair;
  pair.positions = {Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(1, 2, 3)};
  pair.masses = {0.1, 0.2};
  pair.springs = {{0, 1}};
  pair.stiffness = {100.0};
  pair.damping = {{1.0}};
  pair.rest_lengths = {{0.5}};
  for (Scheme scheme : {Scheme::kLinearImplicitEuler, Scheme::kImplicitEuler}) {
    Simulation simulation(netScene(pair, scheme, 60.0));
    for (int n = 0; n < 600; ++n) ASSERT_EQ(simulation.step().status, StepStatus::kConverged);
    const Vectors& x = simulation.state().positions;
    EXPECT_NEAR((x.col(0) - x.col(1)).norm(), 0.5, 0.005);  // 1 % of the rest length
    // 1e-12: the center of mass keeps its place but for rounding.
    EXPECT_LT((x * simulation.model().masses / 0.3 - Eigen::Vector3d(1, 2, 3)).norm(), 1e-12);
  }
}

// A spring of rest length 0 is linear in all three directions, also through its ends' meeting.
TEST(Stepper, RestLengthZeroIsALinearSpring) {
  Oscillator oscillator;
  oscillator.rest_length = 0.0;
  const double rate = 50.0, w = oscillator.angularFrequency();
  Simulation simulation(oscillator.scene(Scheme::kImplicitEuler, rate));
  double u0 = oscillator.amplitude, u1 = u0;
  for (int n = 0; n < 100; ++n) {
    ASSERT_EQ(simulation.step().status, StepStatus::kConverged);
    const double u2 = simulation.state().positions(0, 1);
    // (1 + w^2 h^2) u_{n+1} - 2 u_n + u_{n-1} = 0; 1e-12: rounding over 100 steps.
    EXPECT_LT(std::abs((1 + w * w / (rate * rate)) * u2 - 2 * u1 + u0), 1e-12);
    u0 = u1;
    u1 = u2;
  }
}

// a-b and b-a are one spring of the summed stiffness.
TEST(Stepper, DuplicateSpringsAddUp) {
  Particles net = randomNet(10, 50.0, 0.9, 9);
  Particles twice = net, stiff = net;
  for (std::size_t s = 0; s < net.springs.size(); ++s) {
    twice.springs.push_back({net.springs[s][1], net.springs[s][0]});
    twice.stiffness.push_back(net.stiffness[s]);
    twice.rest_lengths->push_back((*net.rest_lengths)[s]);
    stiff.stiffness[s] *= 2.0;
  }
  for (const SchemeInfo& scheme : schemes()) {
    if (scheme.scheme == Scheme::kXpbd) continue;  // it takes one after the other
    Simulation a(netScene(twice, scheme.scheme, 2000.0)), b(netScene(stiff, scheme.scheme, 2000.0));
    for (int n = 0; n < 50; ++n) {
      a.step();
      b.step();
    }
    // 1e-12: the same sums in another order.
    EXPECT_LT((a.state().positions - b.state().positions).norm(), 1e-12) << scheme.name;
  }
}

}  // namespace
}  // namespace mass_spring
