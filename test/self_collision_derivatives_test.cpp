#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <optional>
#include <random>

#include "effects/self_collision.h"
#include "mass_spring_sim/measures.h"
#include "probe.h"
#include "problems.h"
#include "sanitizers.h"
#include "solvers/block_pattern.h"
#include "solvers/step_matrix.h"

// Nearest points and what follows from them: energies, forces and matrices are derivatives of one
// another, and what elements do to each other sums up to nothing.
namespace mass_spring {
namespace {

Corners randomCorners(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> number(-size, size);
  return Corners::NullaryExpr([&] { return number(random); });
}

class EitherElements : public testing::TestWithParam<Elements> {};
INSTANTIATE_TEST_SUITE_P(Pairs, EitherElements,
                         testing::Values(Elements::kParticleAndTriangle, Elements::kSegments));

TEST_P(EitherElements, NothingIsNearerThanTheNearestPoints) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  for (int trial = 0; trial < 300; ++trial) {
    const Corners x = randomCorners(random, 1.0);
    const Proximity near = proximity(GetParam(), x);
    // Rounding of numbers of size 1.
    EXPECT_NEAR((x * near.weights - near.distance * near.normal).norm(), 0.0, 1e-14);
    EXPECT_NEAR(near.weights.sum(), 0.0, 1e-14);
    EXPECT_LE(leastDistance(GetParam(), x), near.distance + 1e-14);
    for (int other = 0; other < 100; ++other) {
      const double s = share(random), u = share(random), total = s + u;
      const Eigen::Vector4d weights =
          GetParam() == Elements::kSegments ? Eigen::Vector4d(1.0 - s, s, u - 1.0, -u)
          : total > 1.0                     ? Eigen::Vector4d(1.0, 1.0 - total, s - 1.0, u - 1.0)
                                            : Eigen::Vector4d(1.0, total - 1.0, -s, -u);
      if (total > 1.0 && GetParam() != Elements::kSegments) continue;
      EXPECT_GE((x * weights).norm(), near.distance - 1e-14);
    }
  }
}

TEST_P(EitherElements, NothingIsNearerOnTheWay) {
  std::mt19937 random(8);
  int apart = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    Corners from = randomCorners(random, 1.0), to = from + randomCorners(random, 0.5);
    from.col(0).x() += 2.0;
    to.col(0).x() += 2.0;
    const double least = leastDistance(GetParam(), from, to);
    apart += least > 0.2;
    for (double at = 0.0; at <= 1.0; at += 0.125) {
      // Rounding of numbers of size 1.
      EXPECT_LE(least, proximity(GetParam(), from + at * (to - from)).distance + 1e-14);
    }
  }
  EXPECT_GT(apart, 100);  // it is not a bound of nothing
}

TEST_P(EitherElements, RatesAreDifferencesOfNearestPoints) {
  std::mt19937 random(11);
  constexpr double kStep = 1e-6;
  int compared[3] = {0, 0, 0};
  for (int trial = 0; trial < 1000; ++trial) {
    const Corners x = randomCorners(random, 1.0), dx = randomCorners(random, 1.0);
    const Proximity near = proximity(GetParam(), x);
    const Proximity plus = proximity(GetParam(), x + kStep * dx);
    const Proximity minus = proximity(GetParam(), x - kStep * dx);
    if (plus.freedoms != near.freedoms || minus.freedoms != near.freedoms) continue;
    if (near.distance < 0.05) continue;  // where things turn too fast for differences
    const ProximityRate change = rate(near, x, dx);
    // Truncation: step^2 times third derivatives, up to 1 / sine^4 of two sides; rounding 1e-10.
    const double scale = 1.0 + change.weights.squaredNorm() * change.weights.norm();
    EXPECT_LT((change.normal - (plus.normal - minus.normal) / (2.0 * kStep)).norm(), 1e-7 * scale);
    EXPECT_LT((change.weights - (plus.weights - minus.weights) / (2.0 * kStep)).norm(),
              1e-7 * scale);
    EXPECT_NEAR(near.normal.dot(dx * near.weights),
                (plus.distance - minus.distance) / (2.0 * kStep), 1e-8 * scale);
    ++compared[near.freedoms];
  }
  for (const int count : compared) EXPECT_GT(count, 20);
}

// Against the volume that the corners span, which changes its sign where lines meet.
TEST_P(EitherElements, TouchesWhatItPassesThroughAndNothingElse) {
  std::mt19937 random(13);
  int passed = 0, missed = 0;
  const int trials = underSanitizers() ? 200 : 2000;
  for (int trial = 0; trial < trials; ++trial) {
    const Corners from = randomCorners(random, 1.0);
    const Corners to = from + randomCorners(random, 0.5);
    double least = 1.0;
    for (int n = 0; n <= 2000; ++n) {
      const double at = n / 2000.0;
      least = std::min(least, proximity(GetParam(), (1.0 - at) * from + at * to).distance);
    }
    const bool touches = firstTouch(GetParam(), from, to).has_value();
    const double approach = mostApproach(GetParam(), to - from);
    if (least < 1e-9 * approach || proximity(GetParam(), from).distance < 0.01) continue;
    // Between two of the places seen, the distance falls by half of what it can on the way.
    if (touches) {
      EXPECT_LT(least, approach / 4000.0 + 1e-3);
      ++passed;
    }
    if (least > approach / 4000.0 + 1e-3) {
      EXPECT_FALSE(touches);
      ++missed;
    }
  }
  EXPECT_GT(passed, trials / 70);
  EXPECT_GT(missed, trials / 4);
}

/// Two small sheets and two ropes thrown into each other.
struct Tangle {
  Tangle() {
    Scene scene = sheetsAndRopes(5, 6, Scheme::kImplicitEuler);
    scene.effects.self_collision = SelfCollisionOptions{0.05, 100.0};
    model = buildModel(scene);
    probe.emplace(*model.effects.back());
    std::mt19937 random(5);
    std::uniform_real_distribution<double> number(-0.15, 0.15);
    for (Vectors* vectors : {&x, &dx, &start}) {
      *vectors = Vectors::NullaryExpr(3, model.particleCount(), [&] { return number(random); });
    }
    start = x + 0.3 * start;
    none = Vectors::Zero(3, model.particleCount());
  }
  Vectors forces(const Vectors& positions) {
    Vectors f = none;
    probe->addForces(positions, none, f);
    return f;
  }
  double energy(const Vectors& positions) {
    Vectors ignored = none;
    Energy energy;
    double dissipation = 0.0;
    probe->addForces(positions, none, ignored, energy, dissipation);
    return energy.elastic;
  }
  Model model;
  std::optional<Probe> probe;
  Vectors x, dx, start, none;
};

class SubstepUnderWay : public testing::TestWithParam<bool> {
 protected:
  SubstepUnderWay() {
    if (GetParam()) tangle_.probe->beginSubstep(tangle_.start, tangle_.none, 0.01);
  }
  Tangle tangle_;
};
INSTANTIATE_TEST_SUITE_P(SelfCollision, SubstepUnderWay, testing::Bool());

TEST_P(SubstepUnderWay, ForcesAreDerivativesOfEnergy) {
  Tangle& t = tangle_;
  constexpr double kStep = 1e-7;
  const Vectors forces = t.forces(t.x);
  EXPECT_GT(forces.norm(), 10.0);
  for (Eigen::Index i = 0; i < forces.size(); i += underSanitizers() ? 10 : 1) {
    Vectors plus = t.x, minus = t.x;
    plus.data()[i] += kStep;
    minus.data()[i] -= kStep;
    // Energies of 50 J: rounding 1e-14 / step; truncation step times jumps of the stiffness.
    EXPECT_NEAR(forces.data()[i], (t.energy(minus) - t.energy(plus)) / (2.0 * kStep),
                1e-4 * forces.norm())
        << i;
  }
}

TEST_P(SubstepUnderWay, ForceDerivativeIsExact) {
  Tangle& t = tangle_;
  constexpr double kStep = 1e-8;
  Vectors df = t.none;
  t.probe->addForceDerivative(t.x, t.none, t.dx, t.none, df);
  const Vectors difference =
      (t.forces(t.x + kStep * t.dx) - t.forces(t.x - kStep * t.dx)) / (2.0 * kStep);
  EXPECT_GT(df.norm(), 10.0);
  // Rounding 1e-15 / step; a few pairs are nearly parallel and turn fast.
  EXPECT_LT((df - difference).norm(), 1e-5 * df.norm());
}

TEST_P(SubstepUnderWay, ForcesAndTorquesSumUpToNothing) {
  Tangle& t = tangle_;
  const Vectors forces = t.forces(t.x);
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < forces.cols(); ++i) {
    torque += Eigen::Vector3d(t.x.col(i)).cross(Eigen::Vector3d(forces.col(i)));
  }
  // Rounding.
  EXPECT_LT(forces.rowwise().sum().norm(), 1e-13 * forces.norm());
  EXPECT_LT(torque.norm(), 1e-13 * forces.norm());
}

TEST_P(SubstepUnderWay, MatrixIsTheDerivativeBesideWhatTurnsIt) {
  Tangle& t = tangle_;
  StepMatrix matrix(t.model.pattern);
  matrix.setMasses(0.0, t.model.masses);
  t.probe->addDerivatives(t.x, t.none, {0.0, 0.0, 1.0}, Projection::kNone, matrix);
  ASSERT_GT(matrix.ties().size(), 50u);
  Vectors product = t.none;
  double curvature = 0.0;
  matrix.multiply(t.dx, product);
  for (const Tie& tie : matrix.ties()) {
    double along = 0.0;
    for (int a = 0; a < 4; ++a) {
      along +=
          tie.weights[a] * tie.normal.dot(t.dx.col(tie.particles[static_cast<std::size_t>(a)]));
    }
    curvature += tie.stiffness * along * along;
  }
  // The same in another order.
  EXPECT_NEAR(product.cwiseProduct(t.dx).sum(), curvature, 1e-12 * curvature);
}

// Whether pairs are found anew or kept from places nearby, they give the same bytes.
TEST(SelfCollision, DoesNotDependOnWhereItLookedBefore) {
  Tangle fresh, moved;
  moved.forces(moved.x + 0.01 * moved.dx);
  moved.forces(moved.start);
  EXPECT_TRUE(sameBytes(fresh.forces(fresh.x), moved.forces(moved.x)));
  Energy here, there;
  fresh.probe->addEnergy(fresh.x, here);
  moved.probe->addEnergy(moved.x, there);
  EXPECT_EQ(here.elastic, there.elastic);
  EXPECT_GT(here.elastic, 0.1);
}

}  // namespace
}  // namespace mass_spring
