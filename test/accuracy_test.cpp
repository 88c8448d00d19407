#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "local_spectrum.h"
#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/simulation.h"
#include "probe.h"
#include "problems.h"
#include "sanitizers.h"
#include "scheme_choice.h"

// Accuracy as a request, budgets, and the choice of a scheme.
namespace mass_spring {
namespace {

Scene swingingNet(Scheme scheme, double stiffness) {
  Particles net = randomNet(20, stiffness, 0.95, 4);
  net.damping.emplace(net.springs.size(), 0.02);
  Scene scene = netScene(net, scheme, 60.0);
  scene.effects.gravity = GravityOptions{Eigen::Vector3d(0, 0, -9.81)};
  pin(scene, {0, 1});
  return scene;
}

Vectors positionsAfter(const Scene& scene, double time, StepTotals* totals = nullptr) {
  Simulation simulation(scene);
  while (simulation.state().time < time - 1e-9) {
    EXPECT_EQ(simulation.step().status, StepStatus::kConverged);
  }
  if (totals) *totals = simulation.totals();
  return simulation.state().positions;
}

double rms(const Vectors& a, const Vectors& b) {
  return std::sqrt((a - b).squaredNorm() / static_cast<double>(a.cols()));
}

class Accuracy : public testing::TestWithParam<Scheme> {};
INSTANTIATE_TEST_SUITE_P(Schemes, Accuracy,
                         testing::Values(Scheme::kSymplecticEuler, Scheme::kRk4, Scheme::kTrBdf2,
                                         Scheme::kRos3),
                         [](const auto& p) { return name(p.param); });

TEST_P(Accuracy, IsMetAndCostsSubsteps) {
  Scene reference = swingingNet(Scheme::kRk4, 300.0);
  reference.solver.substeps = 400;
  const double time = underSanitizers() ? 0.1 : 0.5;
  const Vectors exact = positionsAfter(reference, time);
  std::uint64_t substeps_before = 0;
  for (const double accuracy : {1e-2, 1e-3, 1e-4}) {
    Scene scene = swingingNet(GetParam(), 300.0);
    scene.solver.accuracy = accuracy;
    StepTotals totals;
    const Vectors x = positionsAfter(scene, time, &totals);
    // 2: the estimates are of local errors, which grow on the way.
    EXPECT_LT(rms(x, exact), 2.0 * accuracy);
    EXPECT_GE(totals.substeps, substeps_before);
    EXPECT_LE(totals.estimated_error, accuracy);
    substeps_before = totals.substeps;
  }
  EXPECT_GT(substeps_before, 60.0 * time);  // more than steps: there was something to control
}

// Symplectic Euler is of first order; between half kicks it is of second, damping included.
TEST(Accuracy, HalfKicksGainAnOrder) {
  Oscillator oscillator;
  oscillator.damping = 1.0;
  const auto error = [&](int substeps, double accuracy) {
    Scene scene = oscillator.scene(Scheme::kSymplecticEuler, 10.0);
    scene.solver.substeps = substeps;
    if (accuracy > 0.0) scene.solver.accuracy = accuracy;
    const Vectors x = positionsAfter(scene, 1.0);
    return std::abs(x(0, 1) - oscillator.rest_length - oscillator.displacement(1.0));
  };
  // An accuracy of a kilometer asks for no more sub-steps. 0.1: the next terms of the expansions.
  EXPECT_NEAR(std::log2(error(256, 1e3) / error(512, 1e3)), 2.0, 0.1);
  EXPECT_NEAR(std::log2(error(256, 0.0) / error(512, 0.0)), 1.0, 0.1);
}

// Where the accuracy asks for nothing, stability still does: an energy that has grown tenfold has
// left it.
TEST(Accuracy, SubstepsOfVerletKeepItStable) {
  for (const double damping : {0.0, 0.05, 5.0}) {
    Particles net = randomNet(25, 1e4, 1.0, 2);
    if (damping > 0.0) net.damping.emplace(net.springs.size(), damping);
    net.velocities.assign(25, Eigen::Vector3d(0.1, 0.0, 0.0));
    for (std::size_t i = 0; i < 25; i += 2) net.velocities[i] = Eigen::Vector3d(0.1, 0.2, -0.1);
    Scene scene = netScene(net, Scheme::kSymplecticEuler, 60.0);
    scene.solver.accuracy = 1e3;
    Simulation simulation(scene);
    const double start = energy(simulation.model(), simulation.state()).total();
    for (int n = 0; n < 300; ++n) ASSERT_EQ(simulation.step().status, StepStatus::kConverged);
    EXPECT_LT(energy(simulation.model(), simulation.state()).total(), 10.0 * start) << damping;
    EXPECT_EQ(simulation.totals().rejected_steps, 0u);
  }
}

// A pull that comes and goes: sub-steps follow, and come back.
TEST(Accuracy, RefinesOnlyWhereNeeded) {
  Scene scene = swingingNet(Scheme::kTrBdf2, 300.0);
  std::get<Particles>(scene.objects[0].shape).damping->assign(39, 1.0);
  scene.solver.accuracy = 1e-3;
  Simulation simulation(scene);
  for (int n = 0; n < 300; ++n) simulation.step();
  ForceCommand pull;
  pull.particles = {7};
  pull.forces = {Eigen::Vector3d(100, 0, 0)};
  pull.duration = 0.05;
  const std::uint32_t calm = simulation.step().substeps;
  ASSERT_TRUE(simulation.apply(pull).accepted());
  std::uint32_t most = 0, last = 0;
  for (int n = 0; n < 300; ++n) {
    last = simulation.step().substeps;
    most = std::max(most, last);
  }
  EXPECT_GT(most, 2 * calm);
  EXPECT_LE(last, 2 * calm);
}

TEST(Accuracy, OutOfReachIsSaid) {
  Scene scene = swingingNet(Scheme::kTrBdf2, 300.0);
  scene.solver.accuracy = 1e-14;
  scene.rate = 1000.0;
  Simulation simulation(scene);
  const StepReport report = simulation.step();
  EXPECT_EQ(report.status, StepStatus::kDegraded);
  EXPECT_NE(report.message.find("accuracy"), std::string::npos) << report.message;
}

TEST(Budget, OfNothingTakesTheCheapestWay) {
  Scene scene = swingingNet(Scheme::kTrBdf2, 300.0);
  scene.solver.budget = 1e-12;
  Simulation simulation(scene);
  simulation.step();  // learns what a sub-step costs
  for (int n = 0; n < 20; ++n) {
    const StepReport report = simulation.step();
    EXPECT_EQ(report.scheme, Scheme::kLinearImplicitEuler);
    EXPECT_EQ(report.substeps, 1u);
    EXPECT_GT(report.budget_used, 1.0);
  }
}

TEST(Budget, BuysSubsteps) {
  Scene scene = swingingNet(Scheme::kTrBdf2, 300.0);
  // A sub-step of twenty particles takes some ten microseconds on any machine of this century.
  scene.solver.budget = 0.25;
  Simulation simulation(scene);
  simulation.step();
  const StepReport report = simulation.step();
  EXPECT_EQ(report.scheme, Scheme::kTrBdf2);
  EXPECT_GT(report.substeps, 2u);
  EXPECT_GT(report.budget_used, 0.0);
}

// A budget pays for one attempt: what gains energy is slowed down instead of redone, unless what it
// gained is more than its kinetic energy.
TEST(Budget, IsNotSpentTwice) {
  Scene scene = netScene(chain(20, 0.05, Eigen::Vector3d::UnitX(), 0.01, 1e6),
                         Scheme::kLinearImplicitEuler, 60.0);
  scene.effects.gravity = GravityOptions{Eigen::Vector3d(0, 0, -9.81)};
  pin(scene, {0});
  scene.solver.budget = 1e-12;
  Simulation simulation(scene);
  const double start = energy(simulation.model(), simulation.state()).total();
  int slowed = 0;
  for (int n = 0; n < 200; ++n) {
    const StepReport report = simulation.step();
    if (report.message.find("slowed down") == std::string::npos) continue;
    EXPECT_EQ(report.rejected, 0u);
    EXPECT_EQ(report.substeps, 1u);
    ++slowed;
  }
  EXPECT_GT(slowed, 0);  // it is that kind of scene
  // What the check of a step's energy lets pass in all, of some tenths of a joule.
  EXPECT_LT(energy(simulation.model(), simulation.state()).total(), start + 1e-3);
}

// The bounds hold for the true matrices, here dense, and are not far off.
TEST(SchemeChoice, BoundsTheSpectrum) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Particles net = randomNet(25, 1e3, 0.7, seed);
    net.damping.emplace(net.springs.size(), 0.3);
    for (std::size_t s = 0; s < net.springs.size(); s += 3) net.stiffness[s] *= 50.0;
    const Scene scene = netScene(net, Scheme::kSymplecticEuler, 60.0);
    const Model model = buildModel(scene);
    const Eigen::Index n = 3 * 25;
    Eigen::MatrixXd k = Eigen::MatrixXd::Zero(n, n), d = k;
    for (const Spring& s : model.springs) {
      const Eigen::Vector3d x = model.start.positions.col(s.j) - model.start.positions.col(s.i);
      const Eigen::Matrix3d along = x.normalized() * x.normalized().transpose();
      const double r = 1.0 - s.rest_length / x.norm();
      const Eigen::Matrix3d stiffness =
          s.stiffness * (along + r * (Eigen::Matrix3d::Identity() - along));
      for (auto [matrix, block] :
           {std::pair<Eigen::MatrixXd*, Eigen::Matrix3d>(&k, stiffness),
            std::pair<Eigen::MatrixXd*, Eigen::Matrix3d>(&d, s.damping * along)}) {
        matrix->block<3, 3>(3 * s.i, 3 * s.i) += block;
        matrix->block<3, 3>(3 * s.j, 3 * s.j) += block;
        matrix->block<3, 3>(3 * s.i, 3 * s.j) -= block;
        matrix->block<3, 3>(3 * s.j, 3 * s.i) -= block;
      }
    }
    Eigen::VectorXd root(n);
    for (Eigen::Index i = 0; i < n; ++i) root[i] = 1.0 / std::sqrt(model.masses[i / 3]);
    const auto largest = [&](const Eigen::MatrixXd& matrix) {
      return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(root.asDiagonal() * matrix *
                                                            root.asDiagonal())
          .eigenvalues()
          .maxCoeff();
    };
    const SpectrumBounds bounds = boundSpectrum(model);
    EXPECT_GE(bounds.frequency, std::sqrt(largest(k)));
    EXPECT_GE(bounds.damping, largest(d));
    // At most twice the frequency: tension could make every direction as stiff as the spring.
    EXPECT_LT(bounds.frequency, 2.0 * std::sqrt(largest(k)));
    // With the directions of the springs known, what is left is that bounds add up over springs.
    const SpectrumBounds local =
        LocalSpectrum(model).at(model.start.positions, {}, std::vector<char>(25, 0));
    EXPECT_GE(local.frequency, std::sqrt(largest(k)));
    EXPECT_GE(local.damping, largest(d));
    EXPECT_LT(local.frequency, 1.5 * std::sqrt(largest(k)));
    EXPECT_LT(local.frequency, bounds.frequency);
  }
}

// Springs that have crept to shorter rest lengths are tense, and so are stiff across their
// direction, too. With the rest lengths as built, the bound is too low.
TEST(LocalSpectrum, HoldsForTheRestLengthsThatSpringsHaveCreptTo) {
  const Scene scene = netScene(randomNet(25, 1e3, 1.0, 1), Scheme::kSymplecticEuler, 60.0);
  const Model model = buildModel(scene, true);
  EffectState crept;
  for (const Spring& s : model.springs) crept.rest_lengths.push_back(0.2 * s.rest_length);
  const Vectors& x = model.start.positions;
  const Eigen::Index n = x.size();
  Eigen::MatrixXd k(n, n);
  Probe springs(*model.effects.front(), crept);
  for (Eigen::Index c = 0; c < n; ++c) {
    Vectors unit = Vectors::Zero(3, x.cols()), change = unit;
    unit.data()[c] = 1.0;
    springs.addForceDerivative(x, 0.0 * x, unit, 0.0 * x, change);
    k.col(c) = -Eigen::Map<Eigen::VectorXd>(change.data(), n);
  }
  Eigen::VectorXd root(n);
  for (Eigen::Index i = 0; i < n; ++i) root[i] = 1.0 / std::sqrt(model.masses[i / 3]);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(root.asDiagonal() * k *
                                                              root.asDiagonal());
  const double frequency = std::sqrt(solver.eigenvalues().maxCoeff());
  const std::vector<char> free(25, 0);
  LocalSpectrum spectrum(model);
  EXPECT_GE(spectrum.at(x, crept.rest_lengths, free).frequency, frequency);
  EXPECT_LT(spectrum.at(x, {}, free).frequency, frequency);
}

// Just inside its bound a scheme is stable; an energy that has grown tenfold has left it.
TEST(SchemeChoice, StableStepsAreStable) {
  for (const double damping : {0.0, 0.05, 5.0}) {
    Particles net = randomNet(25, 1e3, 1.0, 2);
    if (damping > 0.0) net.damping.emplace(net.springs.size(), damping);
    net.velocities.assign(25, Eigen::Vector3d::Zero());
    for (std::size_t i = 0; i < 25; i += 2) net.velocities[i] = Eigen::Vector3d(0.1, 0.2, -0.1);
    Scene scene = netScene(net, Scheme::kAuto, 60.0);
    const SpectrumBounds bounds = boundSpectrum(buildModel(scene));
    for (const auto& [scheme, step] :
         {std::pair(Scheme::kSymplecticEuler, stableSymplecticStep(bounds)),
          std::pair(Scheme::kRk4, stableRk4Step(bounds))}) {
      scene.solver.scheme = scheme;
      scene.rate = 1.01 / step;
      Simulation simulation(scene);
      const double start = energy(simulation.model(), simulation.state()).total();
      for (int n = 0; n < 3000; ++n) ASSERT_EQ(simulation.step().status, StepStatus::kConverged);
      EXPECT_LT(energy(simulation.model(), simulation.state()).total(), 10.0 * start)
          << info(scheme).name << ", damping " << damping;
    }
  }
}

TEST(SchemeChoice, SoftScenesAreExplicitAndStiffOnesImplicit) {
  const Simulation soft(swingingNet(Scheme::kAuto, 100.0)), stiff(swingingNet(Scheme::kAuto, 1e9));
  EXPECT_EQ(soft.model().solver.scheme, Scheme::kSymplecticEuler);
  EXPECT_EQ(stiff.model().solver.scheme, Scheme::kTrBdf2);
  for (const Simulation* simulation : {&soft, &stiff}) {
    EXPECT_NE(simulation->model().scheme_reason.find("auto chose"), std::string::npos);
  }
  EXPECT_EQ(soft.matrixNonzeros(), 0u);
  Scene accurate = swingingNet(Scheme::kAuto, 100.0);
  accurate.solver.accuracy = 1e-3;
  EXPECT_EQ(Simulation(accurate).model().solver.scheme, Scheme::kSymplecticEuler);
  accurate.solver.accuracy = 1e-7;  // for a fourth order
  EXPECT_EQ(Simulation(accurate).model().solver.scheme, Scheme::kRk4);
}

// Where steps do not resolve what is fast, ten times the accuracy is ten times the sub-steps of an
// implicit scheme; of an explicit one, which resolves it anyway, it is none.
TEST(SchemeChoice, TightAccuraciesOfStiffScenesAreExplicit) {
  Scene sheet = hangingCloth(12, Scheme::kAuto);
  Cloth& cloth = std::get<Cloth>(sheet.objects[0].shape);
  cloth.stiffness *= 1e4;
  *cloth.shear_stiffness *= 1e4;
  *cloth.bend_stiffness *= 1e4;
  sheet.solver.accuracy = 0.02;
  EXPECT_EQ(buildModel(sheet).solver.scheme, Scheme::kTrBdf2);
  sheet.solver.accuracy = 1e-3;
  EXPECT_EQ(buildModel(sheet).solver.scheme, Scheme::kSymplecticEuler);
}

}  // namespace
}  // namespace mass_spring
