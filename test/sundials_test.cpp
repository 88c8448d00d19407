// A second opinion on the references of accuracy_study: SUNDIALS, another method, with a step
// control of its own. Without it, this is skipped.

#include <gtest/gtest.h>

#include "effects/effect.h"
#include "mass_spring_sim/scene_reader.h"
#include "tools/reference.h"

#ifdef MASS_SPRING_WITH_SUNDIALS
#include <arkode/arkode_erkstep.h>
#include <nvector/nvector_serial.h>
#endif

namespace mass_spring {
namespace {

class SecondOpinion : public ::testing::TestWithParam<const char*> {};

#ifndef MASS_SPRING_WITH_SUNDIALS
TEST_P(SecondOpinion, AgreesWithTheReference) { GTEST_SKIP() << "built without SUNDIALS"; }
#else
/// What the right-hand side needs; the vector is all positions, then all velocities.
struct System {
  System(const Scene& scene, std::vector<char> which)
      : model(buildModel(scene)), pinned(std::move(which)), workspace(model) {}
  Model model;
  std::vector<char> pinned;
  Workspace workspace;
};

int derivative(sunrealtype /*time*/, N_Vector y, N_Vector rate, void* data) {
  System& system = *static_cast<System*>(data);
  const Eigen::Index n = system.model.masses.size();
  const Vectors positions = Eigen::Map<const Vectors>(NV_DATA_S(y), 3, n);
  const Vectors speeds = Eigen::Map<const Vectors>(NV_DATA_S(y) + 3 * n, 3, n);
  Vectors forces = Vectors::Zero(3, n);
  sumForces(system.workspace, nullptr, {positions, speeds, 0.0, system.model.start.effects},
            forces);
  Eigen::Map<Vectors> velocities(NV_DATA_S(rate), 3, n),
      accelerations(NV_DATA_S(rate) + 3 * n, 3, n);
  velocities = speeds;
  for (Eigen::Index i = 0; i < n; ++i) {
    const bool pinned = system.pinned[static_cast<std::size_t>(i)];
    accelerations.col(i) = pinned ? Eigen::Vector3d::Zero().eval()
                                  : Eigen::Vector3d(forces.col(i) / system.model.masses[i]);
  }
  return 0;
}

TEST_P(SecondOpinion, AgreesWithTheReference) {
  const Scene scene = readScene(readYamlText(GetParam(), "scene"), "");
  ReferenceOptions options;
  options.duration = 0.5;
  options.frame_rate = scene.rate;
  options.doubt = 1e-9;
  const Reference reference = findReference(scene, options);

  System system(scene, reference.pinned);
  const State& start = system.model.start;
  const Eigen::Index n = start.positions.size();
  SUNContext context = nullptr;
  ASSERT_EQ(SUNContext_Create(nullptr, &context), 0);
  N_Vector y = N_VNew_Serial(2 * n, context);
  Eigen::Map<Eigen::VectorXd>(NV_DATA_S(y), 2 * n)
      << Eigen::Map<const Eigen::VectorXd>(start.positions.data(), n),
      Eigen::Map<const Eigen::VectorXd>(start.velocities.data(), n);
  void* solver = ERKStepCreate(derivative, 0.0, y, context);
  ERKStepSetUserData(solver, &system);
  ERKStepSetOrder(solver, 8);
  ERKStepSetMaxNumSteps(solver, 1000000);
  ASSERT_EQ(ERKStepSStolerances(solver, 1e-12, 1e-14), ARK_SUCCESS);
  for (const State& frame : reference.frames) {
    sunrealtype time = 0.0;
    ERKStepSetStopTime(solver, frame.time);  // there, not interpolated
    ASSERT_GE(ERKStepEvolve(solver, frame.time, y, &time, ARK_NORMAL), 0);
    ASSERT_EQ(time, frame.time);
    const Eigen::Map<const Vectors> positions(NV_DATA_S(y), 3, n / 3);
    // The doubt, and some 1e-12 of each of a thousand steps.
    EXPECT_LT(reference.distance(positions, frame.positions), 1e-9) << time;
  }
  ERKStepFree(&solver);
  N_VDestroy(y);
  SUNContext_Free(&context);
}
#endif

INSTANTIATE_TEST_SUITE_P(Scenes, SecondOpinion,
                         ::testing::Values(R"(
rate: 60.0
solver: {threads: 1}
objects:
  cord: {type: rope, start: [0.0, 0.0, 1.0], end: [1.0, 0.0, 1.0], segments: 10, mass: 0.1,
         stiffness: 1000.0, bend_stiffness: 10.0, damping: 0.1}
pins: {nail: {object: cord, particles: [0]}}
effects: {gravity: {acceleration: [0.0, 0.0, -9.81]}}
)",
                                           R"(
rate: 60.0
solver: {threads: 1}
objects:
  sheet: {type: cloth, size: [0.5, 0.5], resolution: [6, 6], position: [0.0, 0.0, 1.0], mass: 0.1,
          stiffness: 200.0, shear_stiffness: 100.0, bend_stiffness: 20.0, damping: 0.05}
pins: {corners: {object: sheet, particles: [0, 5]}}
effects: {gravity: {acceleration: [0.0, 0.0, -9.81]}}
)"),
                         [](const auto& scene) { return scene.index == 0 ? "rope" : "cloth"; });

}  // namespace
}  // namespace mass_spring
