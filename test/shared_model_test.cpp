#include <gtest/gtest.h>

#include <thread>

#include "mass_spring_sim/simulation.h"
#include "problems.h"

// One constant model, several simulations.
namespace mass_spring {
namespace {

/// Every effect at once, on a cloth that drapes over a ball which begins to move.
Scene everything(Scheme scheme) {
  Scene scene = hangingCloth(8, scheme);
  scene.rate = info(scheme).implicit ? 100.0 : 2000.0;
  auto& cloth = std::get<Cloth>(scene.objects[0].shape);
  cloth.damping = 0.01;
  scene.effects.air_drag = AirDragOptions{0.001};
  scene.effects.wind.emplace();
  scene.effects.wind->velocity = {1.0, 2.0, 0.0};
  scene.effects.wind->drag = 1.0;
  scene.effects.wind->lift = 0.3;
  scene.effects.wind->gust = GustOptions{0.5, 0.1};
  scene.effects.contact.emplace();
  scene.effects.contact->stiffness = 200.0;
  scene.effects.contact->friction = 0.3;
  scene.effects.contact->shapes = {{"ball", Sphere{{0.5, 0.5, -0.32}, 0.3}}};
  scene.effects.strain_limit = StrainLimitOptions{0.2, 5.0};
  scene.effects.plasticity = PlasticityOptions{0.005, 2.0};
  scene.effects.tearing = TearingOptions{0.5};
  scene.effects.self_collision = SelfCollisionOptions{0.01, 20.0};
  ShapeCommand push;
  push.name = "ball";
  push.target.position = {0.5, 0.5, -0.2};
  push.duration = 0.1;
  scene.timeline.push_back({0.03, push});
  return scene;
}

void run(Simulation& simulation, int steps) {
  for (int n = 0; n < steps; ++n) {
    ASSERT_NE(simulation.step().status, StepStatus::kFailed);
  }
}

class SharedModel : public testing::TestWithParam<Scheme> {};
INSTANTIATE_TEST_SUITE_P(Schemes, SharedModel, testing::ValuesIn(allSchemes()), schemeName);

// Two simulations on two threads, of which one is pushed, do what each does by itself.
TEST_P(SharedModel, SimulationsOnTwoThreadsDoNotKnowOfEachOther) {
  const Scene scene = everything(GetParam());
  const auto model = std::make_shared<const Model>(buildModel(scene));
  const int steps = info(GetParam()).implicit ? 20 : 200;
  ForceCommand push;
  push.forces = {{0.0, 0.0, 0.02}};
  push.duration = -1.0;
  const auto start = [&](std::shared_ptr<const Model> of, bool pushed) {
    auto simulation = std::make_unique<Simulation>(scene, std::move(of));
    if (pushed) {
      EXPECT_TRUE(simulation->apply(push).accepted());
    }
    return simulation;
  };
  std::vector<State> ends;
  for (const bool pushed : {false, true}) {
    const auto alone = start(std::make_shared<const Model>(buildModel(scene)), pushed);
    run(*alone, steps);
    ends.push_back(alone->state());
  }
  EXPECT_FALSE(ends[0] == ends[1]);

  const auto first = start(model, false), second = start(model, true);
  std::thread other([&] { run(*second, steps); });
  run(*first, steps);
  other.join();
  EXPECT_TRUE(first->state() == ends[0]);
  EXPECT_TRUE(second->state() == ends[1]);
}

}  // namespace
}  // namespace mass_spring
