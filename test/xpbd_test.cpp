#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "effects/spring_relaxation.h"
#include "effects/springs.h"
#include "energy_check.h"
#include "mass_spring_sim/simulation.h"
#include "problems.h"
#include "published_xpbd.h"

// xpbd: one spring after the other.
namespace mass_spring {
namespace {

Vectors jittered(const Vectors& positions, double by, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-by, by);
  Vectors moved = positions;
  for (Eigen::Index k = 0; k < moved.size(); ++k) moved.data()[k] += unit(random);
  return moved;
}

// Too few springs for runs, so that the order is that of the list: the method as published.
TEST(Xpbd, IsTheMethodAsPublished) {
  Particles net = randomNet(8, 300.0, 0.9, 4);
  net.damping.emplace(net.springs.size(), 0.3);
  std::sort(net.springs.begin(), net.springs.end(), [](const auto& a, const auto& b) {
    return std::minmax(a[0], a[1]) < std::minmax(b[0], b[1]);
  });
  net.rest_lengths.emplace(net.springs.size(), 0.3);
  Scene scene = netScene(net, Scheme::kXpbd, 60.0);
  scene.solver.substeps = 3;
  scene.effects.gravity = GravityOptions{Eigen::Vector3d(0.0, 0.0, -9.81)};
  pin(scene, {2});
  Simulation simulation(scene);
  std::vector<char> pinned(8, 0);
  pinned[2] = 1;
  PublishedXpbd published(
      {simulation.model(), scene.effects.gravity->acceleration, pinned, 1.0 / 60.0}, 3, 1,
      PublishedXpbd::Order::kOfSprings);
  for (int n = 0; n < 30; ++n) {
    ASSERT_EQ(simulation.step().status, StepStatus::kConverged);
    published.step();
  }
  // The same numbers in another order: rounding, which a net that swings for half a second doubles
  // a few times.
  EXPECT_LT((simulation.state().positions - published.positions()).norm(), 1e-12);
  EXPECT_GT((simulation.state().positions - simulation.model().start.positions).norm(), 0.1);
}

// In runs many lanes are relaxed at once; no two of them may have a particle in common. Rows of 2
// to 20 particles make runs whose ends are 1 to 42 apart.
TEST(Xpbd, LanesAtOnceGiveWhatOneAfterTheOtherGives) {
  for (int columns = 2; columns <= 20; ++columns) {
    Scene scene;
    Cloth cloth;
    cloth.size = Eigen::Vector2d(1.0, 1.0);
    cloth.resolution = {columns, 9};
    cloth.mass = 0.2;
    cloth.stiffness = 1000.0;
    cloth.shear_stiffness = 500.0;
    cloth.bend_stiffness = 100.0;
    cloth.damping = 0.1;
    scene.objects.push_back({"sheet", Eigen::Vector4d::Ones(), cloth});
    const Model model = buildModel(scene);
    const SpringBatches& batches = find<Springs>(model)->batches();
    const double h = 0.01;
    std::vector<char> pinned(model.particleCount(), 0);
    pinned[1] = 1;
    const Vectors before = jittered(model.start.positions, 0.02, 1);
    const Vectors start = jittered(before, 0.02, 2);
    Vectors expected = start;
    SpringBatches::RestLengths room;
    const auto relaxOne = [&](std::uint32_t i, std::uint32_t j, double k, double c, double rest) {
      const double wi = pinned[i] ? 0.0 : 1.0 / model.masses[i];
      const double wj = pinned[j] ? 0.0 : 1.0 / model.masses[j];
      const Eigen::Vector3d d = expected.col(j) - expected.col(i);
      const Eigen::Vector3d n = d.normalized();
      const double f = k * (d.norm() - rest) + c / h * n.dot(d - (before.col(j) - before.col(i)));
      const Eigen::Vector3d moved = h * h * f / (1.0 + (k * h * h + c * h) * (wi + wj)) * n;
      expected.col(i) += wi * moved;
      expected.col(j) -= wj * moved;
    };
    for (const SpringBatch& run : batches.runs()) {
      const RelaxedLanes relaxed(run);
      for (std::uint32_t pass = 0; pass < relaxed.passes; ++pass) {
        for (std::uint32_t s = 0; s < run.lanes; ++s) {
          if (!relaxed.inPass(pass, s)) continue;
          if (std::find(run.gaps.begin(), run.gaps.end(), s) != run.gaps.end()) continue;
          const std::size_t value = run.uniform ? 0 : s;
          relaxOne(run.i + s, run.j + s, batches.stiffness(run)[value], batches.damping(run)[value],
                   batches.restLength(run, {}, room)[value]);
        }
      }
    }
    for (const SpringBatch& batch : batches.gathered()) {
      for (std::size_t s = 0; s < batch.ends_i.size(); ++s) {
        relaxOne(batch.ends_i[s], batch.ends_j[s], batches.stiffness(batch)[s],
                 batches.damping(batch)[s], batches.restLength(batch, {}, room)[s]);
      }
    }
    Vectors positions = start;
    SpringRelaxation(batches, model.masses).relax(h, pinned, {}, before, positions);
    // Rounding of sums of some 20 terms of a meter; a lane that missed its neighbor's move would
    // be off by millimeters.
    EXPECT_LT((positions - expected).cwiseAbs().maxCoeff(), 1e-13) << columns;
    EXPECT_EQ(positions.col(1), start.col(1));
    EXPECT_GT((positions - start).norm(), 1e-3);
  }
}

TEST(Xpbd, KeepsMomentum) {
  Scene scene = hangingCloth(7, Scheme::kXpbd);
  scene.pins.clear();
  scene.effects = {};
  Simulation simulation(scene);
  const Vectors thrown = jittered(Vectors::Zero(3, 49), 1.0, 3);
  ASSERT_TRUE(simulation.setState(simulation.state().positions, thrown).accepted());
  const Model& model = simulation.model();
  const auto momentum = [&] {
    return Eigen::Vector3d(simulation.state().velocities * model.masses);
  };
  const Eigen::Vector3d pushed = momentum();
  for (int n = 0; n < 50; ++n) simulation.step();
  // What each spring does to its ends is opposite: 0.2 kg at 1 m/s, rounded some thousands of
  // times.
  EXPECT_LT((momentum() - pushed).norm(), 1e-13);
}

// Springs give way to coarse steps as if they were soft, and hold energies that were never there.
// What moves may not have more of it than there was.
TEST(Xpbd, IsSlowedDownWhereMoreMovesThanThereWas) {
  Scene scene = Oscillator().scene(Scheme::kXpbd, 60.0);  // 1.25 J in the spring, at rest
  const Model model = buildModel(scene);
  const std::vector<char> pinned = {1, 0};
  const Drive drive{pinned, nullptr, model.start.effects, 0.0};
  Workspace workspace(model);
  EnergyCheck check(workspace, Scheme::kXpbd);
  check.start(1.0 / 60.0, model.start, drive);
  State end = model.start;
  const double most = std::sqrt(2.0 * 1.25 / 0.3);  // m/s
  end.velocities(1, 1) = 0.99 * most;
  EXPECT_FALSE(check.gained(end, drive));
  end.velocities(1, 1) = 1.01 * most;
  EXPECT_TRUE(check.gained(end, drive));
  EXPECT_TRUE(check.slowDown(end, drive));
  EXPECT_NEAR(end.velocities(1, 1), most, 1e-12);
  // All of it is used up now.
  check.accept();
  check.start(1.0 / 60.0, end, drive);
  end.velocities(1, 1) *= 1.01;
  EXPECT_TRUE(check.gained(end, drive));
}

}  // namespace
}  // namespace mass_spring
