#include "effects/strain_limit.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>

#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/simulation.h"
#include "probe.h"
#include "problems.h"
#include "sanitizers.h"
#include "scene_text.h"
#include "scheme_choice.h"
#include "solvers/step_matrix.h"

// Springs that stiffen beyond a strain, against finite differences and closed forms.
namespace mass_spring {
namespace {

Vectors randomVectors(Eigen::Index n, double size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-size, size);
  Vectors a(3, n);
  for (Eigen::Index i = 0; i < a.size(); ++i) a.data()[i] = number(random);
  return a;
}

/// A net of which some springs are beyond their limit, none so near it that differences see a kink.
struct Stretched {
  Stretched() : model(build()), limit(options(), model.springs), x(model.start.positions) {
    x += randomVectors(x.cols(), 0.1, 3);
    limit.findSlots(*model.pattern);
    for (const Spring& s : model.springs) {
      beyond += strain(s, x) > options().max_strain;
      EXPECT_GT(std::abs(strain(s, x) - options().max_strain), 1e-4);
    }
  }
  static StrainLimitOptions options() { return {0.1, 7.0}; }
  static Model build() {
    return buildModel(netScene(randomNet(12, 30.0, 0.95, 3), Scheme::kImplicitEuler, 100.0));
  }
  Vectors forces(const Vectors& positions) const {
    Vectors f = Vectors::Zero(3, x.cols());
    Probe(limit).addForces(positions, 0.0 * x, f);
    return f;
  }

  Model model;
  StrainLimit limit;
  Vectors x;
  int beyond = 0;
};

// Of numbers up to 300: rounding 1e-14 * 300 / step, truncation step^2 * 300 / length^2, with
// lengths from 0.1 m on.
constexpr double kProbe = 1e-5, kProbeError = 5e-6;

TEST(StrainLimit, ForceIsTheDerivativeOfTheEnergyAndSoOn) {
  const Stretched net;
  ASSERT_GT(net.beyond, 5);
  ASSERT_LT(net.beyond, static_cast<int>(net.model.springs.size()) - 3);
  const Vectors dx = randomVectors(12, 1.0, 5), plus = net.x + kProbe * dx,
                minus = net.x - kProbe * dx;
  const auto elastic = [&](const Vectors& x) {
    Energy energy;
    Probe(net.limit).addEnergy(x, energy);
    return energy.elastic;
  };
  const double slope = (elastic(plus) - elastic(minus)) / (2.0 * kProbe);
  EXPECT_GT(std::abs(slope), 0.1);
  EXPECT_NEAR(net.forces(net.x).cwiseProduct(dx).sum(), -slope, kProbeError);

  Vectors df = 0.0 * dx, product(3, 12);
  Probe(net.limit).addForceDerivative(net.x, 0.0 * dx, dx, dx, df);
  EXPECT_GT(df.norm(), 10.0);
  EXPECT_LT((df - (net.forces(plus) - net.forces(minus)) / (2.0 * kProbe)).norm(), kProbeError);

  StepMatrix matrix(net.model.pattern);
  matrix.setMasses(0.0, net.model.masses);
  Probe(net.limit).addDerivatives(net.x, 0.0 * dx, {0.0, 0.5, 1.0}, Projection::kNone, matrix);
  matrix.multiply(dx, product);
  EXPECT_LT((product + df).norm(), 1e-12 * df.norm());  // rounding
}

TEST(StrainLimit, MatrixIsPositiveSemidefiniteAndBounded) {
  const Stretched net;
  StepMatrix matrix(net.model.pattern);
  matrix.setMasses(0.0, net.model.masses);
  Probe(net.limit).addDerivatives(net.x, 0.0 * net.x, {0.0, 0.0, 1.0}, Projection::kWhereNeeded,
                                  matrix);
  Eigen::MatrixXd dense(36, 36);
  for (Eigen::Index c = 0; c < 36; ++c) {
    Vectors unit = Vectors::Zero(3, 12), product(3, 12);
    unit.data()[c] = 1.0;
    matrix.multiply(unit, product);
    dense.col(c) = Eigen::Map<Eigen::VectorXd>(product.data(), 36);
  }
  const auto smallest = [](const Eigen::MatrixXd& a) {
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(a).eigenvalues()[0];
  };
  EXPECT_GT(smallest(dense), -1e-11);  // rounding of numbers up to 1000
  Eigen::VectorXd held = Eigen::VectorXd::Zero(12), braked = held;
  net.limit.addBounds(held, braked);
  EXPECT_EQ(braked.norm(), 0.0);
  Eigen::MatrixXd gap = -dense;
  for (Eigen::Index i = 0; i < 36; ++i) gap(i, i) += held[i / 3];
  EXPECT_GT(smallest(gap), -1e-11);
}

TEST(StrainLimit, LinearizedForcesAgreeWithTheMatrix) {
  const Stretched net;
  const double w = 0.01;
  for (const double speed : {0.0, 5.0}) {
    const Vectors v = randomVectors(12, speed, 7);
    StepMatrix matrix(net.model.pattern);
    matrix.setMasses(0.0, net.model.masses);
    Vectors f = 0.0 * v, product(3, 12);
    Probe(net.limit).linearize(net.x, v, w, matrix, f);
    matrix.multiply(v, product);
    // At rest, the forces where the springs are. Moving on at v, those that are expected, of the
    // springs that get longer; the others' differ by the second derivative, w^2 |v|^2 K / length.
    const Vectors expected = net.forces(net.x + w * v);
    if (speed == 0.0) {
      EXPECT_LT((f - expected).norm(), 1e-12);
    } else {
      EXPECT_LT((f - product / w - expected).norm(), 0.15 * (net.forces(net.x) - expected).norm());
    }
  }
}

/// k e + r k max(0, e - s L) = T
double elongation(double tension, double stiffness, double length, const StrainLimitOptions& o) {
  const double free = tension / stiffness, room = o.max_strain * length;
  return free <= room ? free : (free + o.stiffness_ratio * room) / (1.0 + o.stiffness_ratio);
}

TEST(StrainLimit, AHangingChainIsAsLongAsTheClosedFormSays) {
  const int links = 6;
  const double mass = 0.1, k = 20.0, length = 0.2;
  for (const Scheme scheme : {Scheme::kImplicitEuler, Scheme::kLinearImplicitEuler}) {
    Scene scene = netScene(chain(links, length, {0, 0, -1}, mass, k), scheme, 10.0);
    scene.effects.gravity = GravityOptions{Eigen::Vector3d(0, 0, -kGravity)};
    scene.effects.strain_limit = StrainLimitOptions{0.5, 100.0};
    scene.solver.newton_tolerance = scene.solver.linear_tolerance = 1e-12;
    pin(scene, {0});
    Simulation simulation(scene);
    for (int n = 0; n < 400; ++n) simulation.step();
    ASSERT_LT(maxSpeed(simulation.state()), 1e-9);
    int limited = 0;
    for (int i = 0; i < links; ++i) {
      const double expected =
          elongation((links - i) * mass * kGravity, k, length, *scene.effects.strain_limit);
      const double strain = mass_spring::strain(
          simulation.model().springs[static_cast<std::size_t>(i)], simulation.state().positions);
      // What is left of the motion, at 1e-9 m/s.
      EXPECT_NEAR(strain * length, expected, 1e-8) << name(scheme) << " " << i;
      limited += strain > 0.5;
    }
    EXPECT_GT(limited, 1);
    EXPECT_LT(limited, links);
  }
}

// No spring of a cloth at rest carries more than the weight.
TEST(StrainLimit, AHangingClothStaysWithinItsLimit) {
  Scene scene = hangingCloth(8, Scheme::kImplicitEuler);
  const double k = 5.0;
  Cloth& sheet = std::get<Cloth>(scene.objects[0].shape);
  sheet.stiffness = k;
  sheet.shear_stiffness = 1.0;
  sheet.bend_stiffness.reset();
  const auto stretch = [&] {
    scene.rate = 20.0;
    Simulation simulation(scene);
    for (int n = 0; n < 200; ++n) EXPECT_NE(simulation.step().status, StepStatus::kFailed);
    double largest = 0.0;
    for (const Spring& s : simulation.model().springs) {
      if (s.kind == SpringKind::kStructural) {
        largest = std::max(largest, strain(s, simulation.state().positions));
      }
    }
    return largest;
  };
  EXPECT_GT(stretch(), 0.1);
  scene.effects.strain_limit = StrainLimitOptions{0.05, 100.0};
  EXPECT_LT(stretch(), 0.05 + 0.2 * kGravity / (k / 7.0) / 101.0);
}

class Limited : public testing::TestWithParam<Scheme> {};
INSTANTIATE_TEST_SUITE_P(Schemes, Limited, testing::ValuesIn(allSchemes()), schemeName);

// Dropped into its limit, a mass comes back no higher, and not before it has been there.
TEST_P(Limited, RunningIntoTheLimitGainsNoEnergy) {
  const bool implicit = info(GetParam()).implicit;
  Scene scene = netScene(chain(3, 0.1, {1, 0, 0}, 0.05, 40.0), GetParam(),
                         implicit                               ? 60.0
                         : GetParam() == Scheme::kExplicitEuler ? 4e5
                                                                : 4000.0);
  scene.effects.gravity = GravityOptions{Eigen::Vector3d(0, 0, -kGravity)};
  scene.effects.strain_limit = StrainLimitOptions{0.1, 100.0};
  pin(scene, {0});
  Simulation simulation(scene);
  const double start = energy(simulation.model(), simulation.state()).total();
  double longest = 0.0;
  while (simulation.state().time < 1.0) {
    ASSERT_NE(simulation.step().status, StepStatus::kFailed);
    longest = std::max(longest, maxStretch(simulation.model(), simulation.state()));
    // Of energies of 0.15 J, a symplectic scheme gains and loses w h = 1 / 20 in turn; explicit
    // Euler grows by its own nature, w^2 h per second.
    const double room = info(GetParam()).implicit ? 0.01 : 0.05;
    ASSERT_LT(energy(simulation.model(), simulation.state()).total(), start + room * 0.15)
        << simulation.state().time;
  }
  EXPECT_GT(longest, 1.1);
  EXPECT_LT(longest, 1.25);  // (4.5 m g l + ...) / (r k) of energy: 0.15 J stretch it by 0.01 m
}

// All springs stay beyond the limit: there is no kink, and the order is the scheme's.
TEST_P(Limited, IsFollowedAtTheOrderOfTheScheme) {
  const auto end = [](double rate) {
    Particles net = chain(3, 0.5, {1, 0, -6}, 0.2, 4.0);
    // About what hangs on each of them.
    net.positions[1] *= 1.45;
    net.positions[2] *= 1.38;
    net.positions[3] *= 1.3;
    Scene scene = netScene(net, GetParam(), rate);
    scene.solver.newton_tolerance = scene.solver.linear_tolerance = 1e-13;
    scene.effects.gravity = GravityOptions{Eigen::Vector3d(0, 0, -kGravity)};
    scene.effects.strain_limit = StrainLimitOptions{0.01, 5.0};
    pin(scene, {0});
    Simulation simulation(scene);
    for (int step = 0; step < static_cast<int>(0.25 * rate); ++step) {
      EXPECT_EQ(simulation.step().status, StepStatus::kConverged);
      for (const Spring& s : simulation.model().springs) {
        EXPECT_GT(strain(s, simulation.state().positions), 0.01);
      }
    }
    return simulation.state().positions;
  };
  const int order = info(GetParam()).order;
  const double rates[] = {0.0, 8192.0, 1024.0, 512.0, 256.0};
  // 0.15: what the next term of the expansion leaves at these steps.
  EXPECT_NEAR(observedOrder(end, rates[order]), order, 0.15);
}

TEST_P(Limited, WithinTheLimitNoBitChanges) {
  Scene free = hangingCloth(4, GetParam());
  free.rate = info(GetParam()).implicit ? 60.0 : 2000.0;
  Scene limited = free;
  limited.effects.strain_limit = StrainLimitOptions{100.0, 100.0};
  Simulation a(free), b(limited);
  for (int n = 0; n < 20; ++n) {
    a.step();
    b.step();
  }
  if (GetParam() == Scheme::kXpbd) {
    // With a limit there is a matrix, of masses alone: other rounding.
    EXPECT_LT((a.state().positions - b.state().positions).norm(), 1e-12);
    return;
  }
  EXPECT_TRUE(sameBytes(a.state().positions, b.state().positions));
  EXPECT_TRUE(sameBytes(a.state().velocities, b.state().velocities));
  EXPECT_EQ(a.matrixNonzeros(), b.matrixNonzeros());
}

// A million times stiffer, thrown into the limit in steps of 0.1 s.
TEST_P(Limited, StaysBoundedHoweverStiff) {
  if (!solvesSprings(GetParam())) return;
  Scene scene = hangingCloth(6, GetParam());
  Cloth& sheet = std::get<Cloth>(scene.objects[0].shape);
  sheet.stiffness *= 1e6;
  *sheet.shear_stiffness *= 1e6;
  *sheet.bend_stiffness *= 1e6;
  scene.rate = 10.0;
  scene.effects.strain_limit = StrainLimitOptions{0.0, 100.0};
  Simulation simulation(scene);
  const double start = energy(simulation.model(), simulation.state()).total();
  for (int n = 0; n < (underSanitizers() ? 5 : 20); ++n) {
    ASSERT_NE(simulation.step().status, StepStatus::kFailed);
    const Energy now = energy(simulation.model(), simulation.state());
    // The check of energies leaves a thousandth of those that take part.
    ASSERT_LT(now.total(), start + 1e-3 * (now.kinetic + now.elastic + std::abs(now.gravity)));
  }
  EXPECT_LT(maxStretch(simulation.model(), simulation.state()), 1.001);
}

TEST(StrainLimit, CountsInTheStepsOfExplicitSchemes) {
  Oscillator oscillator;
  Scene scene = oscillator.scene(Scheme::kSymplecticEuler, 100.0);
  const double plain = boundSpectrum(buildModel(scene)).frequency;
  scene.effects.strain_limit = StrainLimitOptions{0.1, 99.0};
  EXPECT_GE(boundSpectrum(buildModel(scene)).frequency, 10.0 * plain * (1.0 - 1e-12));
}

TEST(StrainLimit, SparesBendingSprings) {
  std::vector<Spring> springs = {{0, 1, 1.0, 10.0, 0.0, SpringKind::kBending}};
  Vectors x(3, 2), f = Vectors::Zero(3, 2);
  x << 0, 2, 0, 0, 0, 0;
  const StrainLimit bending({0.1, 100.0}, springs);
  Probe(bending).addForces(x, x, f);
  EXPECT_EQ(f.norm(), 0.0);
  springs[0].kind = SpringKind::kShear;
  const StrainLimit shear({0.1, 100.0}, springs);
  Probe(shear).addForces(x, x, f);
  EXPECT_NEAR(f(0, 0), 100.0 * 10.0 * 0.9, 1e-12);
}

TEST(StrainLimitReader, ReadsWritesAndRefuses) {
  const Scene scene = readScene(sceneWith("effects.strain_limit", "{max_strain: 0.1}"), "");
  ASSERT_TRUE(scene.effects.strain_limit);
  EXPECT_EQ(scene.effects.strain_limit->max_strain, 0.1);
  EXPECT_EQ(scene.effects.strain_limit->stiffness_ratio, 10.0);
  const std::string yaml = toYaml(scene);
  EXPECT_NE(yaml.find("strain_limit"), std::string::npos);
  EXPECT_EQ(toYaml(readScene(readYamlText(yaml, "scene"), "")), yaml);
  EXPECT_EQ(problemsOf(sceneWith("effects.strain_limit", "{max_strain: -1, stiffness_ratio: 0}")),
            (std::vector<std::string>{
                "effects.strain_limit.max_strain: got -1, expected a number >= 0",
                "effects.strain_limit.stiffness_ratio: got 0, expected a number > 0"}));
}

}  // namespace
}  // namespace mass_spring
