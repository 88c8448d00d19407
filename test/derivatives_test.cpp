#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "effects/gravity.h"
#include "effects/springs.h"
#include "mass_spring_sim/model.h"
#include "probe.h"
#include "problems.h"
#include "solvers/step_matrix.h"

// Every derivative against central differences. With steps d = 1e-5 of positions of size 1 their
// error is d^2 = 1e-10 of truncation and 1e-16 / d = 1e-11 of rounding, relative to forces of size
// k: hence 1e-8 k with room for derivatives that grow near short springs.
namespace mass_spring {
namespace {

constexpr double kStep = 1e-5;
constexpr double kStiffness = 50.0;
// Of central differences: step^2 = 1e-10 times third derivatives of some k / L^2, and energies of
// some J to 1e-16 over the step.
constexpr double kTolerance = 1e-8 * kStiffness;

/// A net with springs in tension (slack < 1) or compression (slack > 1), and moving particles.
Model netModel(double slack) {
  Particles net = randomNet(10, kStiffness, slack, 11);
  net.damping.emplace(net.springs.size(), 3.0);
  for (const auto& x : net.positions) net.velocities.push_back(x.cwiseProduct(x) - x);
  Scene scene = netScene(net, Scheme::kImplicitEuler, 100.0);
  scene.effects.gravity = GravityOptions{Eigen::Vector3d(0.0, 1.0, -9.81)};
  return buildModel(scene);
}

template <typename EffectType>
const Effect& effectOf(const Model& model) {
  for (const auto& effect : model.effects) {
    if (dynamic_cast<const EffectType*>(effect.get())) return *effect;
  }
  throw std::runtime_error("no such effect");
}

/// Velocities at which springs are not damped.
Vectors still(const Model& model) { return Vectors::Zero(3, model.particleCount()); }

Vectors forces(const Effect& effect, const Vectors& x, const Vectors& v) {
  Vectors f = Vectors::Zero(3, x.cols());
  Probe(effect).addForces(x, v, f);
  return f;
}

double potential(const Effect& effect, const Vectors& x) {
  Energy energy;
  Probe(effect).addEnergy(x, energy);
  return energy.total();
}

Eigen::MatrixXd toDense(const StepMatrix& matrix) {
  const std::uint32_t particles = matrix.pattern().size();
  Eigen::MatrixXd dense(3 * particles, 3 * particles);
  Vectors unit(3, particles), column(3, particles);
  for (Eigen::Index c = 0; c < dense.cols(); ++c) {
    unit.setZero();
    unit.data()[c] = 1.0;
    matrix.multiply(unit, column);
    dense.col(c) = Eigen::Map<Eigen::VectorXd>(column.data(), column.size());
  }
  return dense;
}

/// The exact alpha_v D + alpha_x K of one effect as a dense matrix.
Eigen::MatrixXd derivative(const Effect& effect, const Model& model, MatrixWeights weights) {
  StepMatrix matrix(model.pattern);
  matrix.setMasses(0.0, model.masses);
  EXPECT_EQ(Probe(effect).addDerivatives(model.start.positions, model.start.velocities, weights,
                                         Projection::kNone, matrix),
            0u);
  return toDense(matrix);
}

template <typename ForceAt>
Eigen::MatrixXd differences(const Vectors& at, ForceAt force_at) {
  const Eigen::Index n = at.size();
  Eigen::MatrixXd dense(n, n);
  for (Eigen::Index c = 0; c < n; ++c) {
    Vectors plus = at, minus = at;
    plus.data()[c] += kStep;
    minus.data()[c] -= kStep;
    const Vectors change = force_at(plus) - force_at(minus);
    dense.col(c) = -Eigen::Map<const Eigen::VectorXd>(change.data(), n) / (2.0 * kStep);
  }
  return dense;
}

TEST(Derivatives, SpringForceIsTheGradientOfItsEnergy) {
  const Model model = netModel(0.7);
  const Effect& springs = effectOf<Springs>(model);
  const Vectors f = forces(springs, model.start.positions, still(model));
  ASSERT_GT(f.norm(), 1.0);
  for (Eigen::Index c = 0; c < f.size(); ++c) {
    Vectors plus = model.start.positions, minus = plus;
    plus.data()[c] += kStep;
    minus.data()[c] -= kStep;
    EXPECT_NEAR(f.data()[c], (potential(springs, minus) - potential(springs, plus)) / (2 * kStep),
                kTolerance);
  }
}

TEST(Derivatives, GravityForceIsTheGradientOfItsEnergy) {
  const Model model = netModel(1.0);
  const Effect& gravity = effectOf<Gravity>(model);
  const Vectors f = forces(gravity, model.start.positions, model.start.velocities);
  ASSERT_GT(f.norm(), 0.1);
  for (Eigen::Index c = 0; c < f.size(); ++c) {
    Vectors up = model.start.positions;
    up.data()[c] += 1.0;  // linear: any step is exact but for rounding
    EXPECT_NEAR(f.data()[c], potential(gravity, model.start.positions) - potential(gravity, up),
                1e-12);
  }
}

TEST(Derivatives, StiffnessMatrixOfSpringsInTension) {
  const Model model = netModel(0.7);
  const Effect& springs = effectOf<Springs>(model);
  const Eigen::MatrixXd k = derivative(springs, model, {0.0, 0.0, 1.0});
  ASSERT_GT(k.norm(), kStiffness);
  const Eigen::MatrixXd expected = differences(
      model.start.positions, [&](const Vectors& x) { return forces(springs, x, still(model)); });
  EXPECT_LT((k - expected).cwiseAbs().maxCoeff(), kTolerance);
}

TEST(Derivatives, StiffnessMatrixOfSpringsInCompression) {
  const Model model = netModel(1.4);
  const Effect& springs = effectOf<Springs>(model);
  const Eigen::MatrixXd k = derivative(springs, model, {0.0, 0.0, 1.0});
  const Eigen::MatrixXd expected = differences(
      model.start.positions, [&](const Vectors& x) { return forces(springs, x, still(model)); });
  EXPECT_LT((k - expected).cwiseAbs().maxCoeff(), kTolerance);
  // Compression makes it indefinite: the case that projection is for.
  EXPECT_LT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(k).eigenvalues().minCoeff(), -1.0);
}

TEST(Derivatives, DampingMatrix) {
  const Model model = netModel(0.7);
  const Effect& springs = effectOf<Springs>(model);
  const Eigen::MatrixXd d = derivative(springs, model, {0.0, 1.0, 0.0});
  ASSERT_GT(d.norm(), 1.0);
  const Eigen::MatrixXd expected = differences(model.start.velocities, [&](const Vectors& v) {
    return forces(springs, model.start.positions, v);
  });
  EXPECT_LT((d - expected).cwiseAbs().maxCoeff(), kTolerance);
  // Six of its eigenvalues and more are 0, but for rounding.
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(d).eigenvalues().minCoeff(), -1e-12);
}

/// df of all effects along (dx, dv) against central differences of their forces.
void expectForceDerivative(const Model& model, const Vectors& dx, const Vectors& dv) {
  const Vectors& x = model.start.positions;
  const Vectors& v = model.start.velocities;
  for (const auto& effect : model.effects) {
    Vectors df = Vectors::Zero(3, x.cols());
    Probe(*effect).addForceDerivative(x, v, dx, dv, df);
    const Vectors expected = (forces(*effect, x + kStep * dx, v + kStep * dv) -
                              forces(*effect, x - kStep * dx, v - kStep * dv)) /
                             (2.0 * kStep);
    EXPECT_LT((df - expected).cwiseAbs().maxCoeff(), kTolerance) << effect->traits().names[0];
    if (effect->traits().names[0] != "gravity") {
      EXPECT_GT(df.norm(), 1.0) << effect->traits().names[0];
    }
  }
}

// Along x alone, too: there the damping's dependence on the positions shows unmixed.
TEST(Derivatives, ForceDerivativeIsExact) {
  for (double slack : {0.7, 1.4}) {  // tension and compression, nothing is projected
    const Model model = netModel(slack);
    const Vectors dx = model.start.positions.colwise().reverse();
    const Vectors dv = 2.0 * model.start.positions;
    expectForceDerivative(model, dx, dv);
    expectForceDerivative(model, dx, 0.0 * dv);
  }
}

// The step matrix has the same derivatives but for the damping's dependence on the positions.
TEST(Derivatives, ForceDerivativeAgreesWithTheMatrix) {
  const Model model = netModel(1.4);
  const Vectors dx = model.start.positions.colwise().reverse();
  const Vectors rest = Vectors::Zero(3, dx.cols());
  StepMatrix matrix(model.pattern);
  for (const auto& effect : model.effects) {
    matrix.setMasses(0.0, model.masses);
    Probe(*effect).addDerivatives(model.start.positions, model.start.velocities, {0.0, 2.0, 1.0},
                                  Projection::kNone, matrix);
    Vectors product(3, dx.cols()), df = Vectors::Zero(3, dx.cols());
    matrix.multiply(dx, product);
    Probe(*effect).addForceDerivative(model.start.positions, rest, dx, 2.0 * dx, df);
    // 1e-12: sums of some numbers of size k, one after the other.
    EXPECT_LT((product + df).cwiseAbs().maxCoeff(), 1e-12 * kStiffness)
        << effect->traits().names[0];
  }
}

TEST(Derivatives, DissipationIsHalfThePowerLost) {
  const Model model = netModel(0.7);
  const Effect& springs = effectOf<Springs>(model);
  const Vectors f = forces(springs, model.start.positions, model.start.velocities) -
                    forces(springs, model.start.positions, still(model));
  const double power = -f.cwiseProduct(model.start.velocities).sum();
  ASSERT_GT(power, 0.1);
  Vectors ignored = still(model);
  Energy energy;
  double dissipation = 0.0;
  Probe(springs).addForces(model.start.positions, model.start.velocities, ignored, energy,
                           dissipation);
  // 1e-12: the same sum in another order.
  EXPECT_NEAR(dissipation, power / 2.0, 1e-12 * power);
}

// max(r, 0) is the nearest positive semidefinite matrix: the negative eigenvalues become 0, the
// others stay (compared with an eigen-decomposition).
TEST(Derivatives, ProjectionDropsTheNegativeEigenvalues) {
  const Eigen::Vector3d d(0.1, -0.2, 0.25);
  const Eigen::Matrix3d exact = springStiffness(d, 100.0, 0.5, false).dense();
  const Eigen::Matrix3d projected = springStiffness(d, 100.0, 0.5, true).dense();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(exact);
  ASSERT_LT(solver.eigenvalues()[0], -10.0);
  const Eigen::Matrix3d nearest = solver.eigenvectors() *
                                  solver.eigenvalues().cwiseMax(0.0).asDiagonal() *
                                  solver.eigenvectors().transpose();
  EXPECT_LT((projected - nearest).norm(), 1e-12 * 100.0);  // rounding of numbers of size k
}

// Light particles with compressed springs: projected, and then definite.
TEST(Derivatives, ProjectionKeepsTheStepMatrixDefinite) {
  const Model model = netModel(3.0);
  StepMatrix matrix(model.pattern);
  matrix.setMasses(1.0, model.masses);
  EXPECT_GT(Probe(effectOf<Springs>(model))
                .addDerivatives(model.start.positions, still(model), {1.0, 0.0, 1.0},
                                Projection::kWhereNeeded, matrix),
            0u);
  EXPECT_GT(
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(toDense(matrix)).eigenvalues().minCoeff(),
      0.0);
}

}  // namespace
}  // namespace mass_spring
