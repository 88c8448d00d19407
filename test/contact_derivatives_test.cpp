#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>

#include "effects/contact.h"
#include "mass_spring_sim/measures.h"
#include "probe.h"
#include "solvers/block_pattern.h"
#include "solvers/step_matrix.h"

// Shapes and contact: energies, forces and matrices are derivatives of one another.
namespace mass_spring {
namespace {

std::vector<ContactShape> everyShape() {
  return {{"box", Box{{0.1, 0.2, 0.3}, {0.4, 0.5, 0.6}, {0.3, -0.2, 0.7}}},
          {"capsule", Capsule{{-0.3, 0.1, 0.2}, {0.4, 0.3, -0.1}, 0.2}},
          {"plane", Plane{{0.0, 0.1, 0.2}, {1.0, -2.0, 3.0}}},
          {"sphere", Sphere{{0.2, -0.1, 0.3}, 0.35}}};
}

/// Where it starts.
class AtStart {
 public:
  explicit AtStart(const ContactShape& options) : shape_(options), rest_(shape_.start()) {}
  PlacedShape operator*() const { return PlacedShape(shape_, rest_, 0.0); }

 private:
  Shape shape_;
  RigidMotion rest_;
};

TEST(Shape, PlanesAndCapsulesTurnAnyWay) {
  for (const Eigen::Vector3d& towards :
       {Eigen::Vector3d(0.0, 0.0, 2.0), Eigen::Vector3d(0.0, 0.0, -2.0),
        Eigen::Vector3d(1e-9, 0.0, -1.0), Eigen::Vector3d(0.0, -3.0, 0.0),
        Eigen::Vector3d(0.0, -3.0, -0.0), Eigen::Vector3d(-1.0, 2.0, -1e-3),
        Eigen::Vector3d(-1.0, 2.0, 3.0), Eigen::Vector3d(0.3, 0.2, -0.1)}) {
    const Eigen::Vector3d n = towards.normalized();
    const AtStart plane({"plane", Plane{{0.0, 0.0, 0.0}, towards}});
    const AtStart capsule({"capsule", Capsule{{0.0, 0.0, 0.0}, n, 0.1}});
    // Round-off of numbers of size 1.
    EXPECT_LT(((*plane).at({0.1, 0.2, 0.3}).normal - n).norm(), 1e-15) << towards.transpose();
    EXPECT_NEAR((*capsule).distance(1.5 * n), 0.4, 1e-15) << towards.transpose();
    EXPECT_NEAR((*capsule).distance(-0.5 * n), 0.4, 1e-15) << towards.transpose();
  }
}

TEST(Shape, DistanceNormalAndCurvatureAreDerivativesOfEachOther) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-0.6, 0.6);
  constexpr double kStep = 1e-5;
  for (const ContactShape& options : everyShape()) {
    const AtStart start(options);
    const PlacedShape shape = *start;
    int compared = 0;
    for (int trial = 0; trial < 300; ++trial) {
      const Eigen::Vector3d x(place(random), place(random), place(random));
      const Surface surface = shape.at(x);
      EXPECT_EQ(shape.distance(x), surface.distance) << options.name;
      // A few roundings of numbers of size 1.
      EXPECT_NEAR(surface.normal.norm(), 1.0, 1e-14) << options.name;
      // Inside a box the normal jumps from face to face; near its edges differences see both sides.
      if (options.name == "box" && surface.distance < 0.02) continue;
      Eigen::Vector3d slope;
      Eigen::Matrix3d turn;
      bool smooth = true;
      for (int axis = 0; axis < 3; ++axis) {
        const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(axis);
        const Surface plus = shape.at(x + step), minus = shape.at(x - step);
        slope[axis] = (plus.distance - minus.distance) / (2.0 * kStep);
        turn.col(axis) = (plus.normal - minus.normal) / (2.0 * kStep);
        smooth = smooth && (plus.curvature - minus.curvature).norm() < 0.1;
      }
      if (!smooth) continue;
      // Truncation: step^2 times third derivatives of at most 1 / distance^2 = 2500.
      EXPECT_LT((slope - surface.normal).norm(), 1e-6) << options.name;
      EXPECT_LT((turn - surface.curvature).norm(), 1e-4) << options.name;
      ++compared;
    }
    EXPECT_GT(compared, 100) << options.name;
  }
}

// Outside a box the nearest place moves continuously round edges and corners: so does the normal.
TEST(Shape, NormalsTurnRoundTheEdgesOfABoxWithoutAJump) {
  const AtStart start({"box", Box{{0.0, 0.0, 0.0}, {0.2, 0.2, 0.2}, {0.0, 0.0, 0.0}}});
  const PlacedShape box = *start;
  Eigen::Vector3d before = box.at({0.11, -0.2, 0.0}).normal;
  double turned = 0.0;
  for (int step = 1; step <= 4000; ++step) {
    // Along one face, past the edge, and round.
    const double angle = -1.2 + 4.0 * step / 4000.0;
    const Eigen::Vector3d x(0.16 * std::cos(angle), 0.16 * std::sin(angle), 0.099);
    const Eigen::Vector3d normal = box.at(x).normal;
    // The circle passes the edges at some 0.02 m: a step of 1.6e-4 m turns it by 0.01.
    EXPECT_LT((normal - before).norm(), step == 1 ? 1.5 : 0.02) << angle;
    turned += step == 1 ? 0.0 : (normal - before).norm();
    before = normal;
  }
  EXPECT_GT(turned, 1.5);
}

/// Particles in and near the shapes, moving; a third of them slower than the slip velocity.
struct Cloud {
  Vectors x, v, dx, dv;
};
Cloud cloud(double thickness) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-0.6, 0.6);
  std::vector<Eigen::Vector3d> kept;
  while (kept.size() < 60) {
    const Eigen::Vector3d x(number(random), number(random), number(random));
    // Not so near to where contact begins, or inside a box, that differences would see a kink.
    bool kinked = false, touches = false;
    for (const ContactShape& shape : everyShape()) {
      const double distance = (*AtStart(shape)).distance(x);
      kinked = kinked || std::abs(distance - thickness) < 1e-3 ||
               (shape.name == "box" && distance < 1e-3);
      touches = touches || distance < thickness;
    }
    if (touches && !kinked) kept.push_back(x);
  }
  Cloud c;
  for (Vectors* vectors : {&c.x, &c.v, &c.dx, &c.dv}) vectors->resize(3, 60);
  for (Eigen::Index i = 0; i < 60; ++i) {
    c.x.col(i) = kept[static_cast<std::size_t>(i)];
    for (Vectors* vectors : {&c.v, &c.dx, &c.dv}) {
      vectors->col(i) = Eigen::Vector3d(number(random), number(random), number(random));
    }
    if (i % 3 == 0) c.v.col(i) *= 0.01;
  }
  return c;
}

ContactOptions rubbing() {
  ContactOptions options;
  options.stiffness = 1000.0;
  options.shapes = everyShape();
  options.thickness = 0.05;
  options.friction = 0.4;
  options.slip_velocity = 0.02;
  return options;
}

Contact contactOf(const ContactOptions& options) {
  std::vector<Shape> shapes;
  for (const ContactShape& shape : options.shapes) shapes.emplace_back(shape);
  return Contact(options, std::move(shapes), Eigen::VectorXd::Constant(60, 0.1));
}

/// Its shapes are where they start.
Probe resting(const Contact& contact, const ContactOptions& options) {
  EffectState state;
  for (const ContactShape& shape : options.shapes) state.shapes.emplace_back(Shape(shape).start());
  return Probe(contact, state);
}

/// There, too, but they move and turn.
Probe moving(const Contact& contact, const ContactOptions& options) {
  Probe probe = resting(contact, options);
  for (RigidMotion& motion : probe.effects.shapes) {
    const Pose start = motion.at(0.0);
    Pose target = start;
    target.position += Eigen::Vector3d(0.3, -0.2, 0.1);
    target.orientation =
        Eigen::AngleAxisd(0.5, Eigen::Vector3d(1, 2, 2) / 3.0) * target.orientation;
    motion = RigidMotion(start, target, 0.0, 1.0);
  }
  EXPECT_TRUE(probe.dependsOnTime(Vectors::Zero(3, 60)));
  return probe;
}

TEST(Contact, ForcesAreDerivativesOfEnergyAndOfThePotentialOfFriction) {
  const ContactOptions options = rubbing();
  const Contact effect = contactOf(options);
  Probe contact = moving(effect, options);
  const Cloud c = cloud(options.thickness);
  Vectors forces = Vectors::Zero(3, 60);
  contact.addForces(c.x, c.v, forces);
  constexpr double kStep = 1e-6;
  for (Eigen::Index i = 0; i < forces.size(); ++i) {
    const auto potential = [&](double at) {
      Vectors x = c.x, v = c.v, ignored = Vectors::Zero(3, 60);
      x.data()[i] += at;
      v.data()[i] += at;
      Energy energy;
      double friction = 0.0, alone = 0.0;
      contact.addForces(x, c.v, ignored, energy, alone);
      Energy other;
      contact.addForces(c.x, v, ignored, other, friction);
      return energy.elastic + friction;
    };
    // Energies of 100 J: rounding 1e-14 / step, truncation step^2 times third derivatives of
    // friction, mu N / slip velocity^2 = 5e5.
    EXPECT_NEAR(forces.data()[i], (potential(-kStep) - potential(kStep)) / (2.0 * kStep),
                1e-6 * 500)
        << i;
  }
}

TEST(Contact, ForceDerivativeIsExact) {
  const ContactOptions options = rubbing();
  const Contact effect = contactOf(options);
  Probe contact = moving(effect, options);
  const Cloud c = cloud(options.thickness);
  constexpr double kStep = 1e-7;
  for (const double in_time : {0.0, 1.0}) {
    Vectors df = Vectors::Zero(3, 60), plus = df, minus = df;
    contact.addForceDerivative(c.x, c.v, c.dx, in_time * c.dv, df);
    contact.addForces(c.x + kStep * c.dx, c.v + in_time * kStep * c.dv, plus);
    contact.addForces(c.x - kStep * c.dx, c.v - in_time * kStep * c.dv, minus);
    // Relative to derivatives of up to mu N / slip velocity = 4000: truncation 1e-14 * 1e7.
    EXPECT_LT((df - (plus - minus) / (2.0 * kStep)).cwiseAbs().maxCoeff(), 1e-6 * 4000);
    EXPECT_GT(df.norm(), 1000.0);
  }
}

// What the matrix holds is the derivative but for friction's dependence on x, which is not
// symmetric; projected, its blocks are positive semidefinite.
TEST(Contact, MatrixIsTheDerivativeAndDefiniteWhereProjected) {
  const ContactOptions options = rubbing();
  const Contact effect = contactOf(options);
  Probe contact = resting(effect, options);
  const Cloud c = cloud(options.thickness);
  const auto matrix = [&](const Vectors& v, MatrixWeights weights, Projection projection) {
    StepMatrix matrix(std::make_shared<BlockPattern>(60, PatternBuilder()));
    matrix.setMasses(0.0, Eigen::VectorXd::Ones(60));
    contact.addDerivatives(c.x, v, weights, projection, matrix);
    return matrix;
  };
  const auto expectDerivative = [&](const Vectors& v, const Vectors& dx, const Vectors& dv) {
    const StepMatrix exact =
        matrix(v, {0.0, dv.isZero() ? 0.0 : 1.0, dx.isZero() ? 0.0 : 1.0}, Projection::kNone);
    Vectors df = Vectors::Zero(3, 60), product = df;
    contact.addForceDerivative(c.x, v, dx, dv, df);
    exact.multiply(dx + dv, product);
    EXPECT_LT((df + product).cwiseAbs().maxCoeff(), 1e-12 * product.cwiseAbs().maxCoeff());
  };
  const Vectors none = Vectors::Zero(3, 60);
  expectDerivative(none, c.dx, none);  // without sliding there is no friction to change
  expectDerivative(c.v, none, c.dv);
  const StepMatrix projected = matrix(c.v, {0.0, 1.0, 1.0}, Projection::kWhereNeeded);
  for (const SymmetricBlock& block : projected.diagonal()) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(block.dense());
    // Rounding of entries of some thousands.
    EXPECT_GE(solver.eigenvalues().minCoeff(), -1e-9);
  }
}

}  // namespace
}  // namespace mass_spring
