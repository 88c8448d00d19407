#include "effects/wind.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "mass_spring_sim/simulation.h"
#include "probe.h"
#include "problems.h"
#include "sanitizers.h"
#include "solvers/block_pattern.h"
#include "solvers/step_matrix.h"

// Wind against finite differences and closed forms.
namespace mass_spring {
namespace {

WindOptions windOf(const Eigen::Vector3d& velocity, double drag, double lift) {
  WindOptions wind;
  wind.velocity = velocity;
  wind.drag = drag;
  wind.lift = lift;
  return wind;
}

Scene meshScene(std::vector<Eigen::Vector3d> vertices,
                std::vector<std::array<std::uint32_t, 3>> triangles, double mass, Scheme scheme,
                double rate) {
  Mesh mesh;
  mesh.mass = mass;
  mesh.stiffness = 50.0;
  mesh.vertices = std::move(vertices);
  mesh.triangles = std::move(triangles);
  Scene scene;
  scene.rate = rate;
  scene.solver.scheme = scheme;
  scene.objects.push_back({"sheet", Eigen::Vector4d(1, 1, 1, 1), mesh});
  return scene;
}

/// The one sheet whose corners share its mass as they share its area: it stays flat. Level, 0.5
/// m^2.
Scene oneFace(double mass, Scheme scheme, double rate) {
  return meshScene({{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}}, {{0, 1, 2}}, mass, scheme,
                   rate);
}

Vectors randomVectors(Eigen::Index n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  Vectors a(3, n);
  for (Eigen::Index i = 0; i < a.size(); ++i) a.data()[i] = number(random);
  return a;
}

/// Eight faces in all directions between nine crumpled particles that move, in a gust.
struct Crumpled {
  Crumpled(double drag, double lift)
      : model([] {
          Cloth cloth;
          cloth.size = {1.0, 1.0};
          cloth.resolution = {3, 3};
          cloth.mass = 0.1;
          cloth.stiffness = 10.0;
          Scene scene;
          scene.solver.scheme = Scheme::kImplicitEuler;
          scene.objects.push_back({"sheet", Eigen::Vector4d(1, 1, 1, 1), cloth});
          Model model = buildModel(scene);
          model.start.positions = randomVectors(9, 1);
          return model;
        }()),
        wind(options(drag, lift), model),
        x(model.start.positions),
        v(randomVectors(9, 2)) {}
  static WindOptions options(double drag, double lift) {
    WindOptions all = windOf({1.0, -2.0, 0.5}, drag, lift);
    all.gust = GustOptions{0.5, 2.0};
    return all;
  }
  /// Amid a gust.
  Probe probe() const { return Probe(wind, {}, 0.3); }
  Vectors forces(const Vectors& positions, const Vectors& velocities) const {
    Vectors f = Vectors::Zero(3, positions.cols());
    probe().addForces(positions, velocities, f);
    return f;
  }

  Model model;
  Wind wind;
  Vectors x, v;
};

// The signs of all S . u stay the same within the step of 1e-5, whose squared error is 1e-10 and
// whose rounding is 1e-11, relative to numbers of size 1.
TEST(Wind, ForceDerivativeIsExact) {
  constexpr double kStep = 1e-5;
  for (const auto& [drag, lift] : {std::pair(0.5, 0.0), std::pair(0.0, 0.4), std::pair(0.5, 0.4)}) {
    const Crumpled sheet(drag, lift);
    const Vectors dx = randomVectors(9, 3), dv = randomVectors(9, 4), none = 0.0 * dx;
    for (const auto& [along_x, along_v] :
         {std::pair(dx, none), std::pair(none, dv), std::pair(dx, dv)}) {
      Vectors df = none;
      sheet.probe().addForceDerivative(sheet.x, sheet.v, along_x, along_v, df);
      const Vectors expected =
          (sheet.forces(sheet.x + kStep * along_x, sheet.v + kStep * along_v) -
           sheet.forces(sheet.x - kStep * along_x, sheet.v - kStep * along_v)) /
          (2.0 * kStep);
      ASSERT_GT(expected.norm(), 0.1);
      EXPECT_LT((df - expected).cwiseAbs().maxCoeff(), 1e-8);
    }
  }
}

TEST(Wind, MatrixIsOnTheDiagonalAndPositiveSemidefinite) {
  const Crumpled sheet(0.5, 0.4);
  StepMatrix matrix(sheet.model.pattern);
  matrix.setMasses(0.0, sheet.model.masses);
  sheet.probe().addDerivatives(sheet.x, sheet.v, {0.0, 1.0, 1.0}, Projection::kNone, matrix);
  Vectors unit = Vectors::Zero(3, 9), product(3, 9);
  for (Eigen::Index i = 0; i < 9; ++i) {
    Eigen::Matrix3d block;
    for (Eigen::Index c = 0; c < 3; ++c) {
      unit.setZero();
      unit(c, i) = 1.0;
      matrix.multiply(unit, product);
      block.col(c) = product.col(i);
      product.col(i).setZero();
      EXPECT_EQ(product.norm(), 0.0);
    }
    // 1e-15: rounding of numbers of size 1.
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(block).eigenvalues()[0], -1e-15);
  }
}

// Where the wind blows straight at a face that moves as one, D is all there is.
TEST(Wind, MatrixIsExactWhereTheWindIsNormalToAFace) {
  Scene scene = oneFace(0.1, Scheme::kImplicitEuler, 100.0);
  const Model model = buildModel(scene);
  const Wind wind(windOf({0.0, 0.0, 3.0}, 0.8, 0.0), model);
  StepMatrix matrix(model.pattern);
  matrix.setMasses(0.0, model.masses);
  const Vectors &x = model.start.positions, v = Vectors::Zero(3, 3);
  Probe(wind).addDerivatives(x, v, {0.0, 1.0, 0.0}, Projection::kWhereNeeded, matrix);
  const Vectors dv = Eigen::Vector3d(0.3, -0.2, 1.0).replicate(1, 3);
  Vectors product(3, 3), df = Vectors::Zero(3, 3);
  matrix.multiply(dv, product);
  Probe(wind).addForceDerivative(x, v, Vectors::Zero(3, 3), dv, df);
  ASSERT_GT(df.norm(), 0.1);
  EXPECT_LT((product + df).norm(), 1e-14);  // rounding
}

TEST(Wind, LinearizedForcesAgreeWithTheMatrix) {
  const Crumpled sheet(0.5, 0.4);
  StepMatrix matrix(sheet.model.pattern);
  matrix.setMasses(0.0, sheet.model.masses);
  Vectors forces = Vectors::Zero(3, 9), product(3, 9);
  const double w = 0.02;
  sheet.probe().linearize(sheet.x, sheet.v, w, matrix, forces);
  matrix.multiply(sheet.v, product);
  // What is left at the velocities as they are is the force itself, but for rounding.
  EXPECT_LT((forces - product / w - sheet.forces(sheet.x, sheet.v)).norm(), 1e-14);
}

// Straight into the wind, forces have a potential, which Simpson's rule finds exactly.
TEST(Wind, DissipationIsThePotentialOfForcesAlongTheWind) {
  Scene scene = oneFace(0.1, Scheme::kImplicitEuler, 100.0);
  const Model model = buildModel(scene);
  const Wind wind(windOf({0.0, 0.0, 3.0}, 0.8, 0.3), model);
  const auto at = [&](double speed, Vectors& forces) {
    forces.setZero(3, 3);
    Energy energy;
    double dissipation = 0.0;
    Probe(wind).addForces(model.start.positions, Eigen::Vector3d(0, 0, speed).replicate(1, 3),
                          forces, energy, dissipation);
    EXPECT_EQ(energy.total(), 0.0);
    return dissipation;
  };
  Vectors forces, ignored;
  EXPECT_EQ(at(0.0, forces), 0.0);
  const double d = 1e-4;  // of a cubic: d^2 = 1e-8 of truncation
  at(1.2, forces);
  EXPECT_NEAR((at(1.2 + d, ignored) - at(1.2 - d, ignored)) / (2.0 * d), -forces.row(2).sum(),
              1e-8);
}

TEST(Wind, BoundsHoldForTheDerivatives) {
  const Crumpled sheet(0.5, 0.4);
  Eigen::VectorXd stiffness = Eigen::VectorXd::Zero(9), damping = stiffness;
  sheet.wind.addBounds(stiffness, damping);
  EXPECT_EQ(stiffness.norm(), 0.0);
  EXPECT_GT(damping.minCoeff(), 0.0);
  // Slower than the wind, and unit vectors dv, of which the bound holds the sum over a row.
  for (unsigned seed = 10; seed < 30; ++seed) {
    Vectors unit = randomVectors(9, seed), df = Vectors::Zero(3, 9);
    unit.colwise().normalize();
    sheet.probe().addForceDerivative(sheet.x, sheet.v, 0.0 * unit, unit, df);
    for (Eigen::Index i = 0; i < 9; ++i) EXPECT_LE(df.col(i).norm(), damping[i]);
  }
}

TEST(Wind, NoForceOnWhatMovesWithIt) {
  const Crumpled sheet(0.5, 0.4);
  const Wind wind(windOf({1.0, -2.0, 0.5}, 0.5, 0.4), sheet.model);
  Vectors forces = Vectors::Zero(3, 9);
  Probe(wind).addForces(sheet.x, Eigen::Vector3d(1.0, -2.0, 0.5).replicate(1, 9), forces);
  EXPECT_LT(forces.norm(), 1e-15);  // the mean of three corners rounds
}

// Keckeisen et al. (2004): along the wind A cos, across it A cos sin, both times rho / 2 |u|^2.
TEST(Wind, DragAndLiftAreWhatTheFormulaSays) {
  Scene scene = oneFace(0.1, Scheme::kImplicitEuler, 100.0);
  const Model model = buildModel(scene);
  for (const double angle : {0.0, 0.4, 1.2, 2.0, 3.0}) {  // rad, between wind and normal
    const double speed = 4.0;
    const Eigen::Vector3d along(std::sin(angle), 0.0, std::cos(angle));
    Vectors forces = Vectors::Zero(3, 3);
    const Wind wind(windOf(speed * along, 0.7, 0.3), model);
    Probe(wind).addForces(model.start.positions, Vectors::Zero(3, 3), forces);
    const Eigen::Vector3d total = forces.rowwise().sum();
    const double pressure = 0.5 * 1.2 * speed * speed * 0.5 * std::abs(std::cos(angle));
    EXPECT_NEAR(total.dot(along), 0.7 * pressure, 1e-13);
    const double side = std::cos(angle) < 0.0 ? -1.0 : 1.0;
    const Eigen::Vector3d across(-std::cos(angle), 0.0, std::sin(angle));
    EXPECT_NEAR(side * total.dot(across), 0.3 * pressure * std::sin(angle), 1e-13);
    EXPECT_EQ(forces.col(0), forces.col(2));
  }
}

TEST(Wind, PowerIsNoLessThanWhatTheAirDoes) {
  const Crumpled sheet(0.5, 0.4);
  const double power = sheet.forces(sheet.x, sheet.v).cwiseProduct(sheet.v).sum();
  EXPECT_GE(sheet.probe().power(sheet.x, sheet.v), std::max(0.0, power));
  const Vectors with_it = Eigen::Vector3d(0.2, -0.4, 0.1).replicate(1, 9);
  EXPECT_NEAR(sheet.probe().power(sheet.x, with_it),
              sheet.forces(sheet.x, with_it).cwiseProduct(with_it).sum(), 1e-14);
}

TEST(Wind, DependsOnTimeWithAGustOnly) {
  const Crumpled sheet(0.5, 0.4);
  const Wind steady(windOf({1.0, 0.0, 0.0}, 0.5, 0.4), sheet.model);
  EXPECT_FALSE(Probe(steady, {}, 1.0).dependsOnTime(sheet.x));
  const Wind gusty(Crumpled::options(0.5, 0.4), sheet.model);
  const auto forces = [&](double time) {
    Probe probe(gusty, {}, time);
    EXPECT_TRUE(probe.dependsOnTime(sheet.x));
    Vectors f = Vectors::Zero(3, 9);
    probe.addForces(sheet.x, Vectors::Zero(3, 9), f);
    return f;
  };
  // 1.5 times the wind is 2.25 times the force; rounding.
  EXPECT_LT((forces(0.5) - 2.25 * forces(0.0)).norm(), 1e-14);
  EXPECT_LT((forces(2.5) - forces(0.5)).norm(), 1e-13);
}

class Windy : public testing::TestWithParam<Scheme> {};
INSTANTIATE_TEST_SUITE_P(Schemes, Windy, testing::ValuesIn(allSchemes()), schemeName);

// v = v_t tanh(g t / v_t), v_t = sqrt(2 m g / (rho C_D A)) = 1.81 m/s: after 2 s but for 4e-10.
TEST_P(Windy, AFallingSheetReachesItsTerminalVelocity) {
  Scene scene = oneFace(0.1, GetParam(), 500.0);
  scene.effects.gravity = GravityOptions{Eigen::Vector3d(0.0, 0.0, -kGravity)};
  scene.effects.wind = windOf(Eigen::Vector3d::Zero(), 1.0, 0.3);
  const double terminal = std::sqrt(2.0 * 0.1 * kGravity / (1.2 * 1.0 * 0.5));
  Simulation simulation(scene);
  while (simulation.state().time < 0.1) {
    ASSERT_EQ(simulation.step().status, StepStatus::kConverged);
  }
  // Schemes of first order err by h g / 2 = 0.5 %.
  EXPECT_NEAR(simulation.state().velocities(2, 0) / terminal, -std::tanh(kGravity * 0.1 / terminal),
              5e-3);
  while (simulation.state().time < 2.0) {
    ASSERT_EQ(simulation.step().status, StepStatus::kConverged);
  }
  for (int corner = 0; corner < 3; ++corner) {
    EXPECT_NEAR(simulation.state().velocities(2, corner) / terminal, -1.0, 1e-3);
  }
}

TEST_P(Windy, ACoefficientOfZeroChangesNothing) {
  const bool implicit = info(GetParam()).implicit;
  Scene calm = hangingCloth(4, GetParam());
  calm.rate = implicit ? 60.0 : 2000.0;
  Scene windy = calm;
  windy.effects.wind = windOf({3.0, 1.0, 0.0}, 0.0, 0.0);
  Simulation a(calm), b(windy);
  for (int n = 0; n < 20; ++n) {
    a.step();
    b.step();
  }
  if (GetParam() == Scheme::kXpbd) {
    // With wind there is a matrix, of masses alone: (m v + h f) / m is v + h f / m but for
    // rounding.
    EXPECT_LT((a.state().positions - b.state().positions).norm(), 1e-12);
    return;
  }
  EXPECT_EQ(a.state().positions, b.state().positions);
  EXPECT_EQ(a.state().velocities, b.state().velocities);
}

// Stages that felt the wind of another time would leave order 1.
TEST_P(Windy, AGustIsFollowedAtTheOrderOfTheScheme) {
  const auto end = [](double rate) {
    Scene scene = meshScene({{0, 0, 0}, {1, 0, 0}, {0.1, 0.9, 0.1}, {1.1, 0.8, -0.2}},
                            {{0, 1, 2}, {1, 3, 2}}, 2.0, GetParam(), rate);
    scene.solver.newton_tolerance = 1e-13;
    scene.solver.linear_tolerance = 1e-13;
    scene.effects.wind = windOf({1.0, 0.5, 6.0}, 0.9, 0.3);
    scene.effects.wind->gust = GustOptions{0.5, 0.5};
    pin(scene, {0});
    Simulation simulation(scene);
    for (int step = 0; step < static_cast<int>(0.25 * rate); ++step) {
      EXPECT_EQ(simulation.step().status, StepStatus::kConverged);
    }
    return simulation.state().positions;
  };
  const int order = info(GetParam()).order;
  // The coarsest of three rates that double.
  const double rates[] = {0.0, 2048.0, 512.0, 256.0, 128.0};
  // 0.15: what the next term of the expansion leaves at these steps.
  EXPECT_NEAR(observedOrder(end, rates[order]), order, 0.15);
}

class ImplicitWindy : public testing::TestWithParam<Scheme> {};
INSTANTIATE_TEST_SUITE_P(Schemes, ImplicitWindy, testing::ValuesIn(solvingSchemes()), schemeName);

// A plate on a hinge, at rest in a steady wind at the angle a from hanging: a third of drag and
// lift pull at its free corner, and moments balance where
//   tan a = (D cos a / 3) / (m g - L cos a sin a / 3).
TEST_P(ImplicitWindy, AHungSheetRestsWhereDragAndWeightBalance) {
  Scene scene = meshScene({{0.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.5, -1.0}}, {{0, 1, 2}}, 0.09,
                          GetParam(), 100.0);
  std::get<Mesh>(scene.objects[0].shape).stiffness = 1e5;
  std::get<Mesh>(scene.objects[0].shape).damping = 50.0;
  scene.effects.gravity = GravityOptions{Eigen::Vector3d(0.0, 0.0, -kGravity)};
  scene.effects.wind = windOf({2.0, 0.0, 0.0}, 0.8, 0.5);
  pin(scene, {0, 1});
  Simulation simulation(scene);
  while (simulation.state().time < 6.0) {
    ASSERT_EQ(simulation.step().status, StepStatus::kConverged) << simulation.state().time;
  }
  const Eigen::Vector3d free = simulation.state().positions.col(2);
  const double angle = std::atan2(free.x(), -free.z());
  const double pressure = 0.5 * 1.2 * 4.0 * 0.5, mass = 0.03;
  const double drag = 0.8 * pressure, lift = 0.5 * pressure, c = std::cos(angle);
  ASSERT_GT(angle, 0.5);
  // 1e-3: the springs give way by m g / k = 3e-6, and drag has damped the swing, by e^-12.
  EXPECT_NEAR(std::tan(angle), (drag * c / 3.0) / (mass * kGravity - lift * c * free.x() / 3.0),
              1e-3);
  // The pins hold the rest of the wind, and all but nothing of it is left over.
  Vectors forces(3, 3);
  forces.setZero();
  for (const auto& effect : simulation.model().effects) {
    Probe(*effect).addForces(simulation.state().positions, simulation.state().velocities, forces);
  }
  const Eigen::Vector3d pins = -(forces.col(0) + forces.col(1));
  EXPECT_NEAR(pins.x(), -drag * c, 1e-3 * drag);
  EXPECT_NEAR(pins.z(), 3.0 * mass * kGravity - lift * c * std::sin(angle), 1e-3 * drag);
}

TEST_P(ImplicitWindy, AFlagFliesInAStormAndNeverFails) {
  Scene scene = hangingCloth(20, GetParam());
  scene.rate = 100.0;
  auto& cloth = std::get<Cloth>(scene.objects[0].shape);
  cloth.orientation = {1.5707963267948966, 0.0, 0.0};  // upright, across y
  scene.pins.clear();
  std::vector<std::uint32_t> pole;
  for (std::uint32_t row = 0; row < 20; ++row) pole.push_back(20 * row);
  pin(scene, pole);
  scene.effects.wind = windOf({10.0, 1.0, 0.0}, 0.8, 0.2);
  scene.effects.wind->gust = GustOptions{0.3, 0.7};
  Simulation simulation(scene);
  while (simulation.state().time < (underSanitizers() ? 0.1 : 0.5)) {
    const StepReport report = simulation.step();
    ASSERT_NE(report.status, StepStatus::kFailed) << report.message;
  }
  EXPECT_LT(maxStretch(simulation.model(), simulation.state()), 1.5);
  // It stands in the wind instead of hanging down: its free edge is away from the pole.
  EXPECT_GT(simulation.state().positions(0, 19 + 200), 0.0);
}

// Blown at edge-on, a stiff sheet swings along itself many times within a step: what the air feeds
// in shows in the way it has come, not in the velocities at the ends.
TEST(Wind, WhatItFeedsInIsNotTakenForAGain) {
  Scene scene = hangingCloth(8, Scheme::kTrBdf2);
  scene.rate = 100.0;
  auto& cloth = std::get<Cloth>(scene.objects[0].shape);
  cloth.orientation = {1.5707963267948966, 0.0, 0.0};
  cloth.stiffness = 1e4;
  cloth.bend_stiffness = 5.0;
  cloth.damping.reset();
  scene.pins.clear();
  std::vector<std::uint32_t> pole;
  for (std::uint32_t row = 0; row < 8; ++row) pole.push_back(8 * row);
  pin(scene, pole);
  scene.effects.gravity.reset();
  scene.effects.wind = windOf({6.0, 1.0, 0.0}, 0.8, 0.2);
  Simulation simulation(scene);
  for (int n = 0; n < 10; ++n) {
    const StepReport report = simulation.step();
    EXPECT_EQ(report.status, StepStatus::kConverged) << "step " << n << ": " << report.message;
  }
}

// The forces on pins are those of the state's own time.
TEST(Wind, PinsFeelTheGustOfTheMoment) {
  Scene scene = hangingCloth(5, Scheme::kSymplecticEuler);
  scene.rate = 1000.0;
  scene.effects.wind = windOf({3.0, 0.0, -1.0}, 1.0, 0.0);
  scene.effects.wind->gust = GustOptions{0.9, 0.5};
  Simulation simulation(scene);
  simulation.step();
  Workspace workspace(simulation.model());
  State state = simulation.state();
  const auto force = [&] {
    return pinWrenches(workspace, state, simulation.pins(), nullptr).at("hold").force;
  };
  const Eigen::Vector3d now = simulation.pinWrenches().at("hold").force;
  EXPECT_EQ(force(), now);
  state.time = 0.125;  // when the gust is strongest
  EXPECT_GT((force() - now).norm(), 1e-3);
}

}  // namespace
}  // namespace mass_spring
