#include "effects/tearing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/simulation.h"
#include "problems.h"
#include "scene_text.h"

// Springs that break.
namespace mass_spring {
namespace {

void moveTo(Simulation& simulation, const std::string& pin, const Eigen::Vector3d& target) {
  PinCommand move;
  move.action = PinCommand::Action::kMove;
  move.name = pin;
  move.target.position = target;
  ASSERT_TRUE(simulation.apply(move).accepted());
}

/// A cloth held at two opposite edges, the right one of which pull() takes away at 2 m/s.
Scene clothToTear(int n, Scheme scheme) {
  Scene scene = hangingCloth(n, scheme);
  scene.rate = info(scheme).implicit ? 60.0 : scheme == Scheme::kExplicitEuler ? 16000.0 : 2000.0;
  scene.pins.clear();
  std::vector<std::uint32_t> left, right;
  for (int row = 0; row < n; ++row) {
    left.push_back(static_cast<std::uint32_t>(row * n));
    right.push_back(static_cast<std::uint32_t>(row * n + n - 1));
  }
  scene.pins = {{"left", "sheet", left}, {"right", "sheet", right}};
  scene.effects.tearing = TearingOptions{0.3};
  return scene;
}

void pull(Simulation& simulation, const std::function<void(const StepReport&)>& watch = {}) {
  const Eigen::Vector3d start = simulation.pins().all().at("right").target.position;
  while (simulation.state().time < 0.5) {
    const double ahead = simulation.state().time + simulation.stepSize();
    moveTo(simulation, "right", start + 2.0 * ahead * Eigen::Vector3d::UnitX());
    const StepReport report = simulation.step();
    ASSERT_NE(report.status, StepStatus::kFailed) << report.message;
    if (watch) watch(report);
  }
}

/// The piece that each particle belongs to, by the springs that count.
template <typename Counts>
std::vector<std::uint32_t> pieces(const Model& model, Counts counts) {
  std::vector<std::uint32_t> piece(model.particleCount());
  std::iota(piece.begin(), piece.end(), 0u);
  for (bool changed = true; changed;) {
    changed = false;
    for (const Spring& s : model.springs) {
      if (!counts(s) || piece[s.i] == piece[s.j]) continue;
      piece[s.i] = piece[s.j] = std::min(piece[s.i], piece[s.j]);
      changed = true;
    }
  }
  return piece;
}

TEST(Tearing, ASpringBreaksInTheStepThatPassesItsStrain) {
  Scene scene = netScene(chain(1, 0.5, {1, 0, 0}, 0.1, 20.0), Scheme::kTrBdf2, 100.0);
  scene.pins = {{"a", "net", {0}}, {"b", "net", {1}}};
  scene.effects.tearing = TearingOptions{0.5};
  Simulation simulation(scene);
  for (int n = 1; n <= 30; ++n) {
    // 0.01 m a step: 0.25 m, the strain that it bears, after 25 steps; 26 are beyond.
    moveTo(simulation, "b", {0.5 + 0.01 * n - (n == 25 ? 1e-9 : 0.0), 0, 0});
    const StepReport report = simulation.step();
    EXPECT_EQ(report.broken_springs, n == 26 ? 1u : 0u) << n;
    const double expected = n < 26 ? 20.0 * 0.01 * n : 0.0;
    EXPECT_NEAR(simulation.pinWrenches().at("b").force.x(), -expected, 1e-7) << n;
  }
  EXPECT_EQ(simulation.totals().broken_springs, 1u);
  EXPECT_TRUE(simulation.model().springs.empty());
  EXPECT_EQ(simulation.model().effectNames(), std::vector<std::string>{"tearing"});
}

// At rest under a force F the strain is F / (k L): a load of k L max_strain = 4 N is the last.
TEST(Tearing, ASpringBreaksAtTheRightLoad) {
  for (const Scheme scheme : {Scheme::kImplicitEuler, Scheme::kLinearImplicitEuler}) {
    Scene scene = netScene(chain(1, 0.5, {1, 0, 0}, 1e-4, 20.0), scheme, 1.0);
    scene.effects.tearing = TearingOptions{0.4};
    pin(scene, {0});
    Simulation simulation(scene);
    double load = 0.0;
    // After a step of 1 s, w h = 450, of a jump in the load 1 / (w h)^2 is left.
    for (std::uint32_t broken = 0; broken == 0 && load < 5.0;) {
      load += 0.01;
      ForceCommand force;
      force.id = "load";
      force.particles = {1};
      force.forces = {{load, 0, 0}};
      force.duration = -1.0;
      ASSERT_TRUE(simulation.apply(force).accepted());
      broken = simulation.step().broken_springs;
    }
    EXPECT_NEAR(load, 4.01, 0.005) << name(scheme);
  }
}

TEST(Tearing, AChainBreaksAtItsWeakestPlaceAndTheRestFallsFreely) {
  const int links = 10;
  Particles net = chain(links, 0.1, {0, 0, -1}, 0.01, 100.0);
  net.stiffness[6] = 10.0;  // strains: 4 masses on 1 N, ten on 10 N
  Scene scene = netScene(net, Scheme::kTrBdf2, 200.0);
  scene.effects.gravity = GravityOptions{Eigen::Vector3d(0, 0, -kGravity)};
  scene.effects.tearing = TearingOptions{0.35};
  pin(scene, {0});
  Simulation simulation(scene);
  std::uint32_t broken = 0;
  while (broken == 0 && simulation.state().time < 2.0) broken = simulation.step().broken_springs;
  ASSERT_EQ(broken, 1u);
  for (const Spring& s : simulation.model().springs) EXPECT_FALSE(s.i == 6 && s.j == 7);
  const auto below = [&] { return simulation.state().velocities.rightCols(4).rowwise().mean(); };
  const Eigen::Vector3d before = below();
  for (int n = 0; n < 20; ++n) simulation.step();
  // Newton's tolerance, 1e-6 of a link per step of 1/200 s.
  EXPECT_NEAR(below().z(), before.z() - kGravity * 20 / 200.0, 20 * 1e-6 * 0.1 * 200.0);
  EXPECT_EQ(simulation.totals().broken_springs, 1u);
}

TEST(Tearing, RemovingSpringsOnlyTakesEnergyAndFacesGoWithTheirEdges) {
  Simulation simulation(clothToTear(8, Scheme::kTrBdf2));
  std::shared_ptr<const Model> before = simulation.sharedModel();
  const std::size_t faces = before->triangles.size();
  int tears = 0;
  pull(simulation, [&](const StepReport& report) {
    const Model& now = simulation.model();
    EXPECT_EQ(before->springs.size() - now.springs.size(), report.broken_springs);
    if (report.broken_springs == 0) return;
    ++tears;
    EXPECT_LT(energy(now, simulation.state()).elastic, energy(*before, simulation.state()).elastic);
    before = simulation.sharedModel();
  });
  ASSERT_GT(tears, 0);
  const Model& torn = simulation.model();
  EXPECT_LT(torn.triangles.size(), faces);
  EXPECT_GT(torn.triangles.size(), faces / 4);
  for (const auto& corners : torn.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = corners[k], b = corners[(k + 1) % 3];
      EXPECT_TRUE(
          std::any_of(torn.springs.begin(), torn.springs.end(),
                      [&](const Spring& s) { return std::minmax(s.i, s.j) == std::minmax(a, b); }))
          << a << " " << b;
    }
  }
  // In two, and nothing but structural springs holds what is left together.
  const auto all = pieces(torn, [](const Spring&) { return true; });
  EXPECT_EQ(all, pieces(torn, [](const Spring& s) { return s.kind == SpringKind::kStructural; }));
  EXPECT_NE(all[0], all[7]);
  EXPECT_EQ(torn.objects[0].spring_count, torn.springs.size());
  EXPECT_EQ(torn.objects[0].triangle_count, torn.triangles.size());
}

class Torn : public testing::TestWithParam<Scheme> {};
INSTANTIATE_TEST_SUITE_P(Schemes, Torn, testing::ValuesIn(allSchemes()), schemeName);

TEST_P(Torn, ResetBringsAllBack) {
  Simulation simulation(clothToTear(5, GetParam()));
  const std::size_t springs = simulation.model().springs.size();
  pull(simulation);
  const State end = simulation.state();
  const std::uint64_t broken = simulation.totals().broken_springs;
  ASSERT_GT(broken, 0u);
  EXPECT_EQ(simulation.model().springs.size() + broken, springs);
  simulation.reset();
  EXPECT_EQ(simulation.model().springs.size(), springs);
  EXPECT_EQ(simulation.totals().broken_springs, 0u);
  pull(simulation);
  EXPECT_TRUE(sameBytes(simulation.state().positions, end.positions));
  EXPECT_TRUE(sameBytes(simulation.state().velocities, end.velocities));
  EXPECT_EQ(simulation.totals().broken_springs, broken);
}

TEST_P(Torn, ContinueFromCarriesWhatIsBroken) {
  const Scene scene = clothToTear(5, GetParam());
  Simulation before(scene);
  pull(before);
  ASSERT_GT(before.totals().broken_springs, 0u);
  Scene calm = scene;
  calm.effects.tearing.reset();
  calm.effects.wind.emplace();  // on the faces that are left
  calm.effects.wind->velocity = {0.0, 1.0, 0.0};
  calm.effects.wind->drag = 1.0;
  Simulation after(calm);
  ASSERT_TRUE(after.continueFrom(before));
  EXPECT_EQ(after.model().springs.size(), before.model().springs.size());
  EXPECT_EQ(after.model().triangles, before.model().triangles);
  EXPECT_EQ(after.matrixNonzeros(), before.matrixNonzeros());
  EXPECT_NE(after.step().status, StepStatus::kFailed);
  after.reset();
  EXPECT_EQ(after.model().springs.size(), Simulation(scene).model().springs.size());
  // And back from a whole one.
  ASSERT_TRUE(before.continueFrom(after));
  EXPECT_EQ(before.model().springs.size(), after.model().springs.size());
}

// Blown apart from its middle by a force that stretches all springs alike.
TEST_P(Torn, WhatIsWhollyTornStillRuns) {
  Scene scene = hangingCloth(5, GetParam());
  scene.rate = 2000.0;
  scene.pins.clear();
  scene.effects.tearing = TearingOptions{1e-6};
  Simulation simulation(scene);
  const Vectors start = simulation.state().positions;
  ForceCommand burst;
  for (std::uint32_t i = 0; i < 25; ++i) {
    burst.particles.push_back(i);
    burst.forces.push_back(50.0 * start.col(i));
  }
  ASSERT_TRUE(simulation.apply(burst).accepted());
  for (int n = 0; n < 200; ++n) ASSERT_NE(simulation.step().status, StepStatus::kFailed);
  EXPECT_TRUE(simulation.model().springs.empty());
  EXPECT_TRUE(simulation.model().triangles.empty());
  // The particles, of 8 g, fly on as the force has left them, and fall; a scheme of first order is
  // off by g h t / 2, and the springs took a part of the force while they were there.
  const double fall = -0.5 * kGravity * 0.01;
  EXPECT_NEAR(simulation.state().positions(2, 12), fall, 3e-4);
  EXPECT_NEAR(simulation.state().positions(0, 24) / start(0, 24), 1.0 + 50.0 / 0.008 / 2000.0 * 0.1,
              0.05);
}

TEST_P(Torn, NothingChangesBeforeTheFirstTear) {
  Scene whole = clothToTear(4, GetParam());
  whole.effects.tearing.reset();
  Scene tearing = whole;
  tearing.effects.tearing = TearingOptions{10.0};
  Simulation a(whole), b(tearing);
  pull(a);
  pull(b);
  EXPECT_TRUE(sameBytes(a.state().positions, b.state().positions));
  EXPECT_EQ(b.totals().broken_springs, 0u);
}

// The pieces of a torn lattice, mesh or rope hang together by structural springs alone.
TEST(Tearing, NothingBridgesATear) {
  Lattice block;
  block.size = {0.3, 0.2, 0.2};
  block.resolution = {4, 3, 3};
  block.mass = 1.0;
  block.stiffness = block.shear_stiffness.emplace(500.0);
  block.bend_stiffness = 50.0;
  Rope rope;
  rope.start = {0, 0, 0};
  rope.end = {0, 0, -1};
  rope.segments = 10;
  rope.mass = 0.1;
  rope.stiffness = 100.0;
  rope.bend_stiffness = 10.0;
  Scene scene;
  scene.objects = {{"block", {1, 1, 1, 1}, block}, {"rope", {1, 1, 1, 1}, rope}};
  const Model model = buildModel(scene);
  Vectors x = model.start.positions;
  EXPECT_TRUE(findBreaking({0.5}, model, x).empty());
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    const bool beyond = i < 36 ? x(0, i) > 0.0 : x(2, i) < -0.45;
    if (beyond) x.col(i) += Eigen::Vector3d(0.2, 0.0, -0.2);
  }
  const std::vector<char> gone = findBreaking({0.5}, model, x);
  for (std::size_t s = 0; s < gone.size(); ++s) {
    const Spring& spring = model.springs[s];
    const auto shift = [&](std::uint32_t i) { return x.col(i) != model.start.positions.col(i); };
    EXPECT_EQ(gone[s] != 0, shift(spring.i) != shift(spring.j)) << spring.i << " " << spring.j;
  }
}

TEST(TearingReader, ReadsWritesAndRefuses) {
  const Scene scene = readScene(sceneWith("effects.tearing", "{max_strain: 0.5}"), "");
  ASSERT_TRUE(scene.effects.tearing);
  EXPECT_EQ(scene.effects.tearing->max_strain, 0.5);
  const std::string yaml = toYaml(scene);
  EXPECT_EQ(toYaml(readScene(readYamlText(yaml, "scene"), "")), yaml);
  EXPECT_NE(yaml.find("tearing"), std::string::npos);
  EXPECT_EQ(problemsOf(sceneWith("effects.tearing", "{max_strain: 0}")),
            std::vector<std::string>{"effects.tearing.max_strain: got 0, expected a number > 0"});
}

}  // namespace
}  // namespace mass_spring
