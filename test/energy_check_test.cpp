#include "energy_check.h"

#include <gtest/gtest.h>

#include <random>

#include "mass_spring_sim/scene_reader.h"
#include "mass_spring_sim/simulation.h"
#include "problems.h"
#include "sanitizers.h"
#include "scene_text.h"

namespace mass_spring {
namespace {

void expectCalm(const Scene& scene, const std::string& what) {
  Simulation simulation(scene);
  const double start = energy(simulation.model(), simulation.state()).total();
  const double seconds = underSanitizers() ? 5.0 : 60.0;
  while (simulation.state().time < seconds) {
    const StepReport report = simulation.step();
    ASSERT_EQ(simulation.totals().unconverged_steps, 0u)
        << what << ", step " << simulation.state().step << ": " << report.message;
  }
  EXPECT_LE(energy(simulation.model(), simulation.state()).total(), start) << what;
}

Scene underGravity(Object object, double rate) {
  Scene scene;
  scene.rate = rate;
  scene.solver.scheme = Scheme::kTrBdf2;
  scene.objects = {std::move(object)};
  scene.effects.gravity = GravityOptions{Eigen::Vector3d(0, 0, -kGravity)};
  return scene;
}

Object rope(int segments, double stiffness, std::optional<double> damping) {
  Rope rope{{0, 0, 1}, {1, 0, 1}, segments, 0.2, stiffness, {}, {}, damping};
  return {"rope", Object().color, rope};
}

Object cloth(int n, double stiffness, std::optional<double> damping) {
  Scene hanging = hangingCloth(n, Scheme::kTrBdf2);
  Cloth cloth = std::get<Cloth>(hanging.objects[0].shape);
  cloth.stiffness = stiffness;
  cloth.shear_stiffness = 0.5 * stiffness;
  cloth.bend_stiffness = 0.1 * stiffness;
  cloth.damping = damping;
  return {"cloth", Object().color, cloth};
}

// Ropes that whip and cloth that swings: the default scheme loses energy and gets some of it back,
// and no step is redone for that. At 50 Hz, in contrast, the free end of a long stiff rope whips so
// fast that a step or two in a minute do fail.
TEST(EnergyCheck, NoStepOfRopesAndClothIsRedone) {
  for (const int segments : {10, 20}) {
    Scene scene = underGravity(rope(segments, 1e4, 0.1), 100.0);
    pin(scene, {0});
    expectCalm(scene, "hanging rope of " + std::to_string(segments));
  }
  Scene sheet = underGravity(cloth(5, 1000.0, 0.1), 100.0);
  pin(sheet, {0, 4});
  expectCalm(sheet, "cloth");
  std::mt19937 random(1);
  const auto between = [&](double low, double high) {
    return low + (high - low) * random() / static_cast<double>(std::mt19937::max());
  };
  for (int n = 0; n < 40; ++n) {
    const double rates[] = {60.0, 80.0, 100.0, 200.0};
    const double rate = rates[random() % 4], stiffness = std::pow(10.0, between(2.0, 5.0));
    const std::optional<double> damping =
        random() % 2 ? std::optional(std::pow(10.0, between(-3.0, 0.0))) : std::nullopt;
    const bool both_ends = random() % 2;
    const bool is_rope = n % 8 != 0;
    const auto size = static_cast<std::uint32_t>(is_rope ? between(2, 41) : between(3, 7));
    Scene scene = underGravity(is_rope ? rope(static_cast<int>(size), stiffness, damping)
                                       : cloth(static_cast<int>(size), stiffness, damping),
                               rate);
    pin(scene, both_ends ? std::vector<std::uint32_t>{0, is_rope ? size : size - 1}
                         : std::vector<std::uint32_t>{0});
    expectCalm(scene, (is_rope ? "rope " : "cloth ") + std::to_string(n) + " of " +
                          std::to_string(size) + ", " + std::to_string(stiffness) + " N/m, " +
                          std::to_string(rate) + " Hz");
  }
}

/// A free particle of 1 kg with that speed [m/s].
State moving(double speed) {
  State state;
  state.positions = Vectors::Zero(3, 1);
  state.velocities = speed * Eigen::Vector3d::UnitX();
  return state;
}

Model oneParticle(Scheme scheme) {
  Particles particle;
  particle.positions = {Eigen::Vector3d::Zero()};
  particle.masses = {1.0};
  return buildModel(netScene(particle, scheme, 100.0));
}

/// Takes a step from one speed to another if that is not a gain. @return whether it was one
bool gains(EnergyCheck& check, double from, double to) {
  const std::vector<char> free = {0};
  const EffectState nothing;
  const Drive drive{free, nullptr, nothing, 0.0};
  check.start(0.01, moving(from), drive);
  if (check.gained(moving(to), drive)) return true;
  check.accept();
  return false;
}

// What tr_bdf2 lost it may get back in any number of steps, but no more than that.
TEST(EnergyCheck, TrBdf2GetsBackNoMoreThanItLost) {
  const Model model = oneParticle(Scheme::kTrBdf2);
  Workspace workspace(model);
  EnergyCheck check(workspace, Scheme::kTrBdf2);
  EXPECT_TRUE(gains(check, 1.0, 1.001));  // 1e-3 J of 1 J: nothing was lost yet
  EXPECT_FALSE(gains(check, 1.0, 0.98));  // loses 0.0198 J
  EXPECT_TRUE(gains(check, 0.98, 1.001));
  EXPECT_FALSE(gains(check, 0.98, 0.99));
  EXPECT_FALSE(gains(check, 0.99, 1.0));
  for (int n = 0; n < 10; ++n) EXPECT_TRUE(gains(check, 1.0, 1.001));
}

// Small gains that add up are seen as soon as there is more than there was.
TEST(EnergyCheck, SmallGainsOfTrBdf2DoNotAddUp) {
  const Model model = oneParticle(Scheme::kTrBdf2);
  Workspace workspace(model);
  EnergyCheck check(workspace, Scheme::kTrBdf2);
  ASSERT_FALSE(gains(check, 1.0, 0.99));
  double speed = 0.99;
  int steps = 0;
  for (; steps < 1000 && !gains(check, speed, 1.0001 * speed); ++steps) speed *= 1.0001;
  // It ends at 1 m/s, but for the 5e-4 of about 1 J that all steps together may gain: 1.0005 m/s.
  // The gain of one step is 1e-4 m/s.
  EXPECT_GT(speed, 1.0003);
  EXPECT_LT(speed, 1.0007);
}

// What was lost long ago is no excuse: only a tenth of the energies before and after a step counts.
TEST(EnergyCheck, ForgetsWhatWasLostLongAgo) {
  const Model model = oneParticle(Scheme::kTrBdf2);
  Workspace workspace(model);
  EnergyCheck check(workspace, Scheme::kTrBdf2);
  ASSERT_FALSE(gains(check, 10.0, 1.0));
  for (int n = 0; n < 3; ++n) ASSERT_FALSE(gains(check, 1.0, 1.0 - 1e-9));
  EXPECT_TRUE(gains(check, 1.0, 1.2));  // 0.22 J, where 0.1 J may come back
}

// The other schemes may not gain more than 1e-3 in one step, whatever they lost before.
TEST(EnergyCheck, OtherSchemesAreLimitedInEachStep) {
  for (const Scheme scheme : {Scheme::kImplicitMidpoint, Scheme::kBdf2, Scheme::kRos3,
                              Scheme::kImplicitEuler, Scheme::kLinearImplicitEuler}) {
    const Model model = oneParticle(scheme);
    Workspace workspace(model);
    EnergyCheck check(workspace, scheme);
    ASSERT_FALSE(gains(check, 1.0, 0.98));
    EXPECT_TRUE(gains(check, 0.98, 0.983)) << name(scheme);
    EXPECT_FALSE(gains(check, 0.98, 0.9805)) << name(scheme);
  }
}

// The midpoint rule in steps that are far too large for a stiff net that flies apart: without the
// check it gains energy for ever. The check sees to it that it never has more than at the start.
TEST(EnergyCheck, HoldsAnExplosionOfTheMidpointRule) {
  Scene scene = netScene(randomNet(30, 1e6, 0.5, 4), Scheme::kImplicitMidpoint, 20.0);
  Simulation simulation(scene);
  const double start = energy(simulation.model(), simulation.state()).total();
  bool said = false;
  for (int n = 0; n < 200; ++n) {
    const StepReport report = simulation.step();
    said = said || report.message.find("gained energy") != std::string::npos;
    // 1e-4 of twice the energy: what all steps together may gain.
    ASSERT_LE(energy(simulation.model(), simulation.state()).total(), 1.0002 * start) << n;
  }
  EXPECT_TRUE(said);
}

}  // namespace
}  // namespace mass_spring
