#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>

#include "mass_spring_sim/simulation.h"
#include "problems.h"
#include "sanitizers.h"

#ifdef __GLIBC__

namespace {
std::atomic<long> allocations{0};
}

extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* pointer, std::size_t size);
// The sanitizers have an allocator of their own.
void* __interceptor_malloc(std::size_t size) __attribute__((weak));
void* __interceptor_calloc(std::size_t count, std::size_t size) __attribute__((weak));
void* __interceptor_realloc(void* pointer, std::size_t size) __attribute__((weak));

void* malloc(std::size_t size) {
  ++allocations;
  return __interceptor_malloc ? __interceptor_malloc(size) : __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++allocations;
  return __interceptor_calloc ? __interceptor_calloc(count, size) : __libc_calloc(count, size);
}
void* realloc(void* pointer, std::size_t size) {
  ++allocations;
  return __interceptor_realloc ? __interceptor_realloc(pointer, size)
                               : __libc_realloc(pointer, size);
}
}

namespace mass_spring {
namespace {

class Allocations : public testing::Test {
  void SetUp() override {
    if (underSanitizers()) GTEST_SKIP() << "their operator new calls no malloc";
  }
};

TEST_F(Allocations, NoneInAStepAfterTheFirst) {
  for (const SchemeInfo& scheme : schemes()) {
    for (LinearSolver solver :
         {LinearSolver::kConjugateGradient, LinearSolver::kCholesky, LinearSolver::kMultigrid}) {
      Scene scene = hangingCloth(20, scheme.scheme);
      // Where explicit schemes explode, messages say so.
      scene.rate = scheme.implicit ? 400.0 : 20000.0;
      scene.solver.linear_solver = solver;
      Simulation simulation(scene);
      ForceCommand push;
      push.forces = {Eigen::Vector3d(0, 0.01, 0)};
      push.duration = -1.0;
      simulation.apply(push);
      simulation.step();
      const long before = allocations;
      for (int n = 0; n < 10; ++n) simulation.step();
      EXPECT_EQ(allocations - before, 0) << scheme.name << ", " << name(solver);
      EXPECT_EQ(simulation.totals().unconverged_steps, 0u) << scheme.name << ", " << name(solver);
    }
  }
}

TEST_F(Allocations, NoneWithAllEffects) {
  for (const SchemeInfo& scheme : schemes()) {
    Scene scene = hangingCloth(10, scheme.scheme);
    scene.rate = 2000.0;
    scene.effects.air_drag = AirDragOptions{1e-4};
    scene.effects.wind.emplace();
    scene.effects.wind->velocity = {2.0, 1.0, 0.0};
    scene.effects.wind->drag = 1.0;
    scene.effects.wind->gust = GustOptions{0.5, 0.1};
    scene.effects.contact.emplace();
    scene.effects.contact->stiffness = 50.0;
    scene.effects.contact->friction = 0.5;
    scene.effects.contact->thickness = 0.02;
    // The sheet, level at z = 0, touches both from the start.
    scene.effects.contact->shapes = {{"ball", Sphere{{0.0, 0.0, -0.3}, 0.29}},
                                     {"floor", Plane{{0.0, 0.0, -0.01}, {0.0, 0.0, 1.0}}}};
    Simulation simulation(scene);
    simulation.step();
    const long before = allocations;
    for (int n = 0; n < 10; ++n) simulation.step();
    EXPECT_EQ(allocations - before, 0) << scheme.name;
  }
}

TEST_F(Allocations, NoneWhereSpringsStiffenAndYieldAndDoNotBreak) {
  for (const SchemeInfo& scheme : schemes()) {
    Scene scene = hangingCloth(10, scheme.scheme);
    scene.rate = scheme.implicit ? 2000.0 : 20000.0;
    scene.effects.strain_limit = StrainLimitOptions{2e-5, 10.0};
    scene.effects.tearing = TearingOptions{1.0};
    scene.effects.plasticity = PlasticityOptions{1e-5, 1.0};
    Simulation simulation(scene);
    simulation.step();
    const long before = allocations;
    // Long enough that explicit schemes compare energies, and that states are kept to go back to.
    const int steps = scheme.implicit ? 40 : 600;
    for (int n = 0; n < steps; ++n) simulation.step();
    EXPECT_EQ(allocations - before, 0) << scheme.name;
    EXPECT_GT(maxStretch(simulation.model(), simulation.state()), 1.00002);
  }
}

TEST_F(Allocations, NoneWhereSheetsLieOnEachOther) {
  for (const SchemeInfo& scheme : schemes()) {
    Scene scene = hangingCloth(10, scheme.scheme);
    scene.rate = 2000.0;
    scene.objects.push_back(scene.objects.front());
    scene.objects.back().name = "upper";
    std::get<Cloth>(scene.objects.back().shape).position.z() += 0.018;
    scene.effects.self_collision = SelfCollisionOptions{0.02, 1.0};
    Simulation simulation(scene);
    // The first touch may cost a step that is redone, and a message that says so.
    for (int n = 0; n < 3; ++n) simulation.step();
    const long before = allocations;
    for (int n = 0; n < 10; ++n) simulation.step();
    EXPECT_EQ(allocations - before, 0) << scheme.name;
  }
}

TEST_F(Allocations, AreCounted) {
  const long before = allocations;
  const Vectors vectors = Vectors::Zero(3, 10);
  const std::vector<int> numbers(100, 1);
  EXPECT_GE(allocations - before, 2) << vectors.size() + static_cast<long>(numbers.size());
}

}  // namespace
}  // namespace mass_spring

#endif
