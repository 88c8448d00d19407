#include "published_xpbd.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tools/reference.h"

namespace mass_spring {
namespace {

constexpr double kRate = 60.0;     // Hz
constexpr double kDuration = 0.5;  // s

/// Two particles on one damped spring, level at the start, the first one pinned.
Scene pendulum() {
  Scene scene;
  scene.rate = kRate;
  Object object;
  object.name = "pendulum";
  Particles particles;
  particles.positions = {Eigen::Vector3d::Zero(), Eigen::Vector3d(0.5, 0.0, 0.0)};
  particles.velocities = {Eigen::Vector3d::Zero(), Eigen::Vector3d(0.0, 0.3, 0.0)};
  particles.masses = {0.1, 0.1};
  particles.springs = {{0, 1}};
  particles.stiffness = {50.0};
  particles.damping = {{0.2}};
  object.shape = particles;
  scene.objects.push_back(object);
  scene.pins.push_back({"top", "pendulum", {0}});
  scene.effects.gravity = GravityOptions{Eigen::Vector3d(0.0, 0.0, -9.81)};
  return scene;
}

double errorAtEnd(const Scene& scene, const Reference& reference, int substeps, int iterations) {
  const Model model = buildModel(scene);
  PublishedXpbd xpbd({model, scene.effects.gravity->acceleration, reference.pinned, 1.0 / kRate},
                     substeps, iterations, PublishedXpbd::Order::kOfSprings);
  for (std::size_t n = 0; n < reference.frames.size(); ++n) xpbd.step();
  return reference.distance(xpbd.positions(), reference.frames.back().positions);
}

// The comparison with rivals is fair only if XPBD solves the same equations: spring, damping and
// gravity alike.
TEST(PublishedXpbd, ConvergesToTheTrajectoryInFirstOrder) {
  const Scene scene = pendulum();
  ReferenceOptions options;
  options.duration = kDuration;
  options.frame_rate = kRate;
  const Reference reference = findReference(scene, options);
  const double coarse = errorAtEnd(scene, reference, 200, 1);
  const double fine = errorAtEnd(scene, reference, 400, 1);
  EXPECT_LT(fine, 2e-4);  // m, of a path of 1 m: without damping it would be 7e-4
  // h^2 adds to each error what these sub-steps, 1 and 0.5 % of the period, leave below 5 %.
  EXPECT_NEAR(coarse / fine, 2.0, 0.1);
}

// Of one constraint the first iteration is nearly the last: further ones change the solution of a
// sub-step by less than the sub-step itself errs.
TEST(PublishedXpbd, IterationsConvergeToTheSameTrajectory) {
  const Scene scene = pendulum();
  ReferenceOptions options;
  options.duration = kDuration;
  options.frame_rate = kRate;
  const Reference reference = findReference(scene, options);
  const double one = errorAtEnd(scene, reference, 200, 1);
  EXPECT_NEAR(errorAtEnd(scene, reference, 200, 10), one, 0.1 * one);
}

}  // namespace
}  // namespace mass_spring
