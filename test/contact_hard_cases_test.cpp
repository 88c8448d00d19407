#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "effects/contact.h"
#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/simulation.h"
#include "problems.h"
#include "sanitizers.h"

// Inputs that break simulators, with contact and friction on: whatever the step and the stiffness,
// states stay finite, no step fails, and nothing gains energy but by the work of moving shapes.
namespace mass_spring {
namespace {

struct Extreme {
  Scheme scheme;
  double step;    // s
  double factor;  // of all stiffness
};

std::vector<Extreme> extremes() {
  std::vector<Scheme> tried = {Scheme::kLinearImplicitEuler, Scheme::kImplicitEuler};
  std::vector<double> steps = {0.1};
  if (!underSanitizers()) {
    tried.insert(tried.end(), {Scheme::kBdf2, Scheme::kTrBdf2, Scheme::kRos3});
    steps.push_back(1.0 / 60.0);
  }
  std::vector<Extreme> all;
  for (const Scheme scheme : tried) {
    for (const double step : steps) {
      for (const double factor : {1.0, 1e6}) all.push_back({scheme, step, factor});
    }
  }
  return all;
}

std::string extremeName(const testing::TestParamInfo<Extreme>& info) {
  return std::string(name(info.param.scheme)) + (info.param.step == 0.1 ? "_100ms" : "_17ms") +
         (info.param.factor == 1.0 ? "_soft" : "_stiff");
}

class ContactHardCases : public testing::TestWithParam<Extreme> {
 protected:
  static constexpr double kThickness = 0.01;

  /// A level sheet of 0.4 m and 6 x 6 particles about the origin.
  Scene sheetScene(std::vector<ContactShape> shapes) const {
    Cloth cloth;
    cloth.size = {0.4, 0.4};
    cloth.resolution = {6, 6};
    cloth.mass = 0.05;
    cloth.stiffness = 100.0 * GetParam().factor;
    cloth.shear_stiffness = 30.0 * GetParam().factor;
    cloth.bend_stiffness = 3.0 * GetParam().factor;
    cloth.damping = 0.02;
    Scene scene;
    scene.objects.push_back({"sheet", Object().color, cloth});
    scene.rate = 1.0 / GetParam().step;
    scene.solver.scheme = GetParam().scheme;
    scene.effects.gravity = GravityOptions{Eigen::Vector3d(0.0, 0.0, -kGravity)};
    ContactOptions& contact = scene.effects.contact.emplace();
    contact.stiffness = 1000.0 * GetParam().factor;
    contact.thickness = kThickness;
    contact.friction = 0.5;
    contact.shapes = std::move(shapes);
    return scene;
  }

  double total(const Simulation& simulation) const {
    return energy(simulation.model(), simulation.state()).total();
  }

  /// Some seconds, in which energy only falls.
  void expectToCalmDown(Simulation& simulation) const {
    const double start = total(simulation);
    // What the run holds above its lowest possible point, 1 m below the origin.
    const double scale = start + 0.05 * kGravity * 1.0;
    double least = start;
    for (int step = 0; step < std::lround(2.0 / GetParam().step); ++step) {
      const StepReport report = simulation.step();
      ASSERT_NE(report.status, StepStatus::kFailed) << report.message;
      ASSERT_EQ(report.status == StepStatus::kDegraded, !report.message.empty());
      ASSERT_FALSE(firstNotFinite(simulation.state()).has_value());
      // What a scheme of second order may gain and lose in turn, as the engine's own check has it.
      ASSERT_LE(total(simulation), least + 2e-3 * scale) << "step " << step;
      least = std::min(least, total(simulation));
    }
  }
};
INSTANTIATE_TEST_SUITE_P(All, ContactHardCases, testing::ValuesIn(extremes()), extremeName);

std::vector<ContactShape> roomOf(double half) {
  std::vector<ContactShape> walls;
  const char* const names[] = {"back", "bottom", "front", "left", "right", "top"};
  for (int wall = 0; wall < 6; ++wall) {
    const Eigen::Vector3d inward = (wall < 3 ? 1.0 : -1.0) * Eigen::Vector3d::Unit(wall % 3);
    walls.push_back({names[wall], Plane{-half * inward, inward}});
  }
  return walls;
}

TEST_P(ContactHardCases, ScrambledSheetInARoomFindsItsWayOut) {
  Scene scene = sheetScene(roomOf(0.3));
  Particles scrambled = byHand(scene);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(-0.28, 0.28);
  for (Eigen::Vector3d& x : scrambled.positions) x = {place(random), place(random), place(random)};
  scene.objects[0].shape = scrambled;
  Simulation simulation(scene);
  const double pressed = total(simulation) + 0.05 * kGravity * 0.3;
  expectToCalmDown(simulation);
  // No deeper in a wall than all of the energy at the start could press one particle.
  const double deepest =
      std::sqrt(2.0 * pressed / scene.effects.contact->stiffness) + 1e-9 - kThickness;
  EXPECT_LE(simulation.state().positions.cwiseAbs().maxCoeff(), 0.3 + std::max(0.0, deepest));
}

ShapeCommand goTo(const char* shape, const Eigen::Vector3d& position, double duration) {
  return {shape, Pose{position, Eigen::Quaterniond::Identity()}, duration};
}

void stepFor(Simulation& simulation, double duration) {
  for (int step = 0; step < std::ceil(duration * simulation.scene().rate - 1e-9); ++step) {
    const StepReport report = simulation.step();
    ASSERT_NE(report.status, StepStatus::kFailed) << report.message;
    ASSERT_FALSE(firstNotFinite(simulation.state()).has_value());
  }
}

// Fingers that overlap by 3 cm leave no place for what is between them.
TEST_P(ContactHardCases, GripperThatSqueezesShutStaysBounded) {
  Scene scene = sheetScene({{"above", Capsule{{-0.3, 0.0, 0.05}, {0.3, 0.0, 0.05}, 0.02}},
                            {"below", Capsule{{-0.3, 0.0, -0.05}, {0.3, 0.0, -0.05}, 0.02}}});
  Simulation simulation(scene);
  simulation.apply(goTo("above", {0.0, 0.0, 0.005}, 0.3));
  simulation.apply(goTo("below", {0.0, 0.0, -0.005}, 0.3));
  stepFor(simulation, 0.4);
  expectToCalmDown(simulation);
  // A particle is in both at once, by no more than their radius and thickness each.
  for (const auto& [name, wrench] : simulation.shapeWrenches()) {
    EXPECT_LE(wrench.force.norm(), scene.effects.contact->stiffness * 36 * (0.02 + kThickness));
  }
}

// Two plates with 4 mm between them, each of which keeps off 10 mm.
TEST_P(ContactHardCases, SheetPressedBetweenPlatesStaysBetweenThem) {
  Simulation simulation(sheetScene({{"above", Plane{{0.0, 0.0, 0.05}, {0.0, 0.0, -1.0}}},
                                    {"below", Plane{{0.0, 0.0, -0.05}, {0.0, 0.0, 1.0}}}}));
  simulation.apply(goTo("above", {0.0, 0.0, 0.002}, 0.3));
  simulation.apply(goTo("below", {0.0, 0.0, -0.002}, 0.3));
  stepFor(simulation, 0.4);
  expectToCalmDown(simulation);
  // Both press alike at the middle; gravity and what still swings are small against that.
  EXPECT_LT(simulation.state().positions.row(2).cwiseAbs().maxCoeff(), 0.002);
  const auto wrenches = simulation.shapeWrenches();
  const double weight = 0.05 * kGravity;
  EXPECT_NEAR(wrenches.at("above").force.z() + wrenches.at("below").force.z(), -weight,
              // What swings, m v / step, for schemes that do not damp it at once.
              0.05 * maxSpeed(simulation.state()) * simulation.scene().rate + 1e-3 * weight);
}

}  // namespace
}  // namespace mass_spring
