#include <gtest/gtest.h>

#include <cstring>
#include <functional>

#include "mass_spring_sim/simulation.h"
#include "problems.h"

namespace mass_spring {
namespace {

bool sameBits(const State& a, const State& b) {
  const auto same = [](const Vectors& l, const Vectors& r) {
    return l.size() == r.size() &&
           std::memcmp(l.data(), r.data(), sizeof(double) * static_cast<std::size_t>(l.size())) ==
               0;
  };
  return a.step == b.step && a.time == b.time && same(a.positions, b.positions) &&
         same(a.velocities, b.velocities);
}

ForceCommand push(double newtons, double duration) {
  ForceCommand command;
  command.particles = {20};
  command.forces = {Eigen::Vector3d(0, newtons, 0)};
  command.duration = duration;
  return command;
}

// Explicit schemes explode at the 60 Hz of the others.
constexpr double kExplicitRate = 2000.0;

/// A cloth with commands of a timeline before, at and after the tenth step.
Scene drivenCloth(Scheme scheme, double rate) {
  Scene scene = hangingCloth(6, scheme);
  scene.rate = rate;
  for (const double step : {3.0, 9.0, 10.0, 12.0}) {
    scene.timeline.push_back({step / scene.rate, push(0.1, -1.0)});
  }
  return scene;
}

/// Ten steps, with a pin and forces by commands.
void disturb(Simulation& simulation) {
  for (int n = 0; n < 5; ++n) simulation.step();
  PinCommand grab;
  grab.name = "grab";
  grab.particles = {35};
  grab.here = true;
  ASSERT_TRUE(simulation.apply(grab).accepted());
  grab.action = PinCommand::Action::kMove;
  grab.target.position = simulation.state().positions.col(35) + Eigen::Vector3d(0, 0, 0.01);
  ASSERT_TRUE(simulation.apply(grab).accepted());
  ASSERT_TRUE(simulation.apply(push(0.2, 6.5 / simulation.scene().rate)).accepted());
  for (int n = 0; n < 5; ++n) simulation.step();
}

// What a simulation takes over is all that its future depends on.
TEST(ContinueFrom, GoesOnAsIfNothingHadHappened) {
  for (Scheme scheme : allSchemes()) {
    if (scheme == Scheme::kBdf2) continue;  // its first step has no step before it
    const Scene scene = drivenCloth(scheme, info(scheme).implicit ? 60.0 : kExplicitRate);
    Simulation undisturbed(scene), before(scene), after(scene);
    disturb(undisturbed);
    disturb(before);
    after.step();
    ASSERT_TRUE(after.continueFrom(before));
    EXPECT_EQ(after.pins().all().size(), 2u);
    EXPECT_EQ(after.activeForces(), 3u);  // of the timeline two, which have no end
    EXPECT_EQ(after.totals().steps, 10u);
    for (int n = 0; n < 10; ++n) {
      undisturbed.step();
      after.step();
      ASSERT_TRUE(sameBits(after.state(), undisturbed.state())) << name(scheme) << " " << n;
    }
    EXPECT_EQ(after.activeForces(), 4u);
  }
}

TEST(ContinueFrom, AnotherSchemeTakesOverTheState) {
  for (Scheme from : allSchemes()) {
    for (Scheme to : allSchemes()) {
      const double rate =
          info(from).implicit && info(to).implicit ? 60.0 : kExplicitRate;  // of both
      Simulation before(drivenCloth(from, rate)), after(drivenCloth(to, rate));
      disturb(before);
      ASSERT_TRUE(after.continueFrom(before));
      EXPECT_TRUE(sameBits(after.state(), before.state()));
      const StepReport report = after.step();
      EXPECT_NE(report.status, StepStatus::kFailed);
      EXPECT_EQ(after.state().step, 11u);
      after.reset();
      EXPECT_TRUE(sameBits(after.state(), after.model().start));
    }
  }
}

// A step that fails has had its commands; the scheme that is to do better must not get them twice.
TEST(ContinueFrom, RepeatsNoCommandOfAFailedStep) {
  Scene scene = hangingCloth(6, Scheme::kExplicitEuler);
  scene.limits.max_force = 1e308;
  scene.timeline.push_back({3.0 / scene.rate, push(0.1, -1.0)});
  Simulation before(scene);
  for (int n = 0; n < 3; ++n) before.step();
  // F h / m beyond all numbers, once.
  before.apply(push(1e308, -1.0));
  ASSERT_EQ(before.step().status, StepStatus::kFailed);
  before.clearForces();
  scene.solver.scheme = Scheme::kTrBdf2;
  Simulation after(scene);
  ASSERT_TRUE(after.continueFrom(before));
  after.step();
  EXPECT_EQ(after.state().step, 4u);
  EXPECT_EQ(after.activeForces(), 0u);
}

TEST(ContinueFrom, AppliesWhatLiesAheadInAnotherTimeline) {
  Scene scene = drivenCloth(Scheme::kTrBdf2, 60.0);
  Simulation before(scene);
  for (int n = 0; n < 10; ++n) before.step();
  scene.timeline = {{5.0 / scene.rate, push(0.1, -1.0)}, {10.0 / scene.rate, push(0.1, -1.0)}};
  Simulation after(scene);
  ASSERT_TRUE(after.continueFrom(before));
  EXPECT_EQ(after.activeForces(), 2u);  // of the old timeline
  after.step();
  EXPECT_EQ(after.activeForces(), 3u);
}

TEST(ContinueFrom, NeedsTheSameObjectsPinsAndRate) {
  const Scene scene = hangingCloth(6, Scheme::kTrBdf2);
  Simulation before(scene);
  for (int n = 0; n < 3; ++n) before.step();
  const auto sheet = [](Scene& s) -> Cloth& { return std::get<Cloth>(s.objects[0].shape); };
  const auto continues = [&](const std::function<void(Scene&)>& change) {
    Scene changed = scene;
    change(changed);
    Simulation after(changed);
    const bool continued = after.continueFrom(before);
    EXPECT_TRUE(sameBits(after.state(), continued ? before.state() : after.model().start));
    return continued;
  };
  EXPECT_FALSE(continues([](Scene& s) { s.rate = 61.0; }));
  EXPECT_FALSE(continues([](Scene& s) { s.pins.clear(); }));
  EXPECT_FALSE(continues([](Scene& s) { s.pins[0].particles = {0, 4}; }));
  EXPECT_FALSE(continues([](Scene& s) { s.pins[0].name = "held"; }));
  EXPECT_FALSE(continues([](Scene& s) { s.objects[0].name = s.pins[0].object = "cloth"; }));
  EXPECT_FALSE(continues([&](Scene& s) { sheet(s).resolution = {6, 7}; }));
  EXPECT_FALSE(continues([&](Scene& s) { sheet(s).mass = 0.3; }));
  EXPECT_FALSE(continues([&](Scene& s) { sheet(s).position.z() = 0.5; }));
  EXPECT_FALSE(continues([&](Scene& s) { sheet(s).bend_stiffness.reset(); }));
  EXPECT_FALSE(continues([](Scene& s) {
    s.objects.push_back({"zz", {1, 1, 1, 1}, s.objects[0].shape});
  }));
  EXPECT_FALSE(continues([](Scene& s) { s.pins[0].follow_frame = "tool"; }));
  EXPECT_TRUE(continues([](Scene& s) { s.objects[0].color = {0, 0, 0, 1}; }));
  EXPECT_TRUE(continues([&](Scene& s) { sheet(s).stiffness = 900.0; }));
  EXPECT_TRUE(continues([&](Scene& s) { sheet(s).damping = 0.2; }));
  EXPECT_TRUE(continues([](Scene& s) { s.effects.gravity.reset(); }));
  EXPECT_TRUE(continues([](Scene& s) { s.limits.max_force = 1.0; }));
  EXPECT_TRUE(continues([](Scene& s) { s.solver.substeps = 4; }));
  EXPECT_TRUE(continues([](Scene& s) { s.publish.state = 0.0; }));
  EXPECT_TRUE(continues([](Scene& s) { s.real_time_factor = 0.0; }));
}

}  // namespace
}  // namespace mass_spring
