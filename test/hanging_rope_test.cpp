#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/simulation.h"
#include "problems.h"

// Ropes at rest: a catenary, and the least energy of a cantilever that bends.
namespace mass_spring {
namespace {

/// A rope that cannot stretch, of length S, from (0, 0) to (D, V): it has a lowest point, at x0 and
/// at the arc length s0 from the start, and the radius of curvature R there.
struct Catenary {
  double length, radius, x0, s0;

  Catenary(double length, double distance, double rise) : length(length) {
    // 2 R sinh(D / 2 R) = sqrt(S^2 - V^2), which falls with R.
    const double chord = std::sqrt(length * length - rise * rise);
    double low = 0.02 * distance, high = 100.0 * distance;
    for (int bisection = 0; bisection < 100; ++bisection) {
      radius = 0.5 * (low + high);
      (2.0 * radius * std::sinh(0.5 * distance / radius) > chord ? low : high) = radius;
    }
    x0 = 0.5 * distance - radius * std::atanh(rise / length);
    s0 = radius * std::sinh(x0 / radius);
  }
  Eigen::Vector2d at(double s) const {
    const double along = s - s0;
    return {x0 + radius * std::asinh(along / radius),
            std::hypot(radius, along) - std::hypot(radius, s0)};
  }
};

class CatenaryAtRest : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Rises, CatenaryAtRest, testing::Values(0.0, 0.3));

TEST_P(CatenaryAtRest, IsThatOfTheClosedForm) {
  const int segments = 100;
  const double length = 1.0, distance = 0.6, rise = GetParam(), mass = 0.1;
  Scene scene;
  scene.rate = 10.0;
  scene.solver.scheme = Scheme::kImplicitEuler;
  scene.solver.max_newton_iterations = 200;
  Rope rope;
  rope.start = {0, 0, 0};
  rope.end = {length, 0, 0};
  rope.segments = segments;
  rope.mass = mass;
  rope.axial_rigidity = 1e5;  // N, of a tension of some 0.5 N: it stretches by 5e-6
  scene.objects = {{"rope", {1, 1, 1, 1}, rope}};
  scene.pins = {{"left", "rope", {0}}, {"right", "rope", {segments}}};
  scene.effects.gravity = GravityOptions{Eigen::Vector3d(0, 0, -kGravity)};
  scene.effects.air_drag = AirDragOptions{1e-3};
  Simulation simulation(scene);
  for (int n = 1; n <= 400; ++n) {
    const double share = std::min(1.0, n / 100.0);
    PinCommand move;
    move.action = PinCommand::Action::kMove;
    move.name = "right";
    move.target.position = {length + share * (distance - length), 0.0, share * rise};
    ASSERT_TRUE(simulation.apply(move).accepted());
    ASSERT_NE(simulation.step().status, StepStatus::kFailed);
  }
  ASSERT_LT(maxSpeed(simulation.state()), 1e-6);
  const Catenary expected(length, distance, rise);
  const double sag = -expected.at(expected.s0).y();
  ASSERT_GT(sag, 0.1);
  for (int i = 0; i <= segments; ++i) {
    const Eigen::Vector2d point = expected.at(length * i / segments);
    const Eigen::Vector3d x = simulation.state().positions.col(i);
    // 0.1 % of the sag. Corners of the polygon lie off the curve by a^2 / 8 R = 4e-5 m.
    EXPECT_NEAR(x.x(), point.x(), 1e-3 * sag) << i;
    EXPECT_NEAR(x.z(), point.y(), 1e-3 * sag) << i;
    EXPECT_LT(std::abs(x.y()), 1e-9);
  }
  // The horizontal tension is the weight of R meters; per segment, it is that of one particle.
  const double weight = mass * kGravity / (segments + 1) * segments / length;
  EXPECT_NEAR(simulation.pinWrenches().at("left").force.x() / (weight * expected.radius), 1.0,
              1e-3);
}

/// Energy of springs and weights, its gradient and Hessian, written down once more, for dense
/// matrices of the coordinates of all particles.
struct Potential {
  const std::vector<Spring>& springs;
  const Eigen::VectorXd& masses;
  Eigen::Index held;  // particles at the beginning
  double value = 0.0;
  Eigen::VectorXd gradient;
  Eigen::MatrixXd hessian;

  void evaluate(const Eigen::VectorXd& x) {
    value = 0.0;
    gradient.setZero(x.size());
    hessian.setZero(x.size(), x.size());
    for (Eigen::Index i = 0; i < masses.size(); ++i) {
      value += masses[i] * kGravity * x[3 * i + 2];
      gradient[3 * i + 2] += masses[i] * kGravity;
    }
    for (const Spring& s : springs) {
      const Eigen::Index i = 3 * s.i, j = 3 * s.j;
      const Eigen::Vector3d d = x.segment<3>(j) - x.segment<3>(i);
      const double l = d.norm(), e = l - s.rest_length;
      const Eigen::Vector3d n = d / l, f = s.stiffness * e * n;
      value += 0.5 * s.stiffness * e * e;
      gradient.segment<3>(j) += f;
      gradient.segment<3>(i) -= f;
      const Eigen::Matrix3d nn = n * n.transpose();
      const Eigen::Matrix3d block = s.stiffness * (nn + e / l * (Eigen::Matrix3d::Identity() - nn));
      hessian.block<3, 3>(i, i) += block;
      hessian.block<3, 3>(j, j) += block;
      hessian.block<3, 3>(i, j) -= block;
      hessian.block<3, 3>(j, i) -= block;
    }
    gradient.head(3 * held).setZero();
    for (Eigen::Index c = 0; c < 3 * held; ++c) {
      hessian.row(c).setZero();
      hessian.col(c).setZero();
      hessian(c, c) = 1.0;
    }
  }

  /// Newton's method, damped until it descends (Levenberg). @return the minimum's coordinates
  Eigen::VectorXd minimize(Eigen::VectorXd x) {
    double damping = 1.0;
    evaluate(x);
    for (int iteration = 0; iteration < 5000 && gradient.norm() > 1e-11; ++iteration) {
      const double before = value;
      const Eigen::MatrixXd damped =
          hessian + damping * Eigen::MatrixXd::Identity(x.size(), x.size());
      const Eigen::LLT<Eigen::MatrixXd> factor(damped);
      const Eigen::VectorXd step =
          factor.info() == Eigen::Success ? Eigen::VectorXd(-factor.solve(gradient)) : 0.0 * x;
      evaluate(x + step);
      if (factor.info() == Eigen::Success && value <= before) {
        x += step;
        damping *= 0.3;
      } else {
        evaluate(x);
        damping = std::max(4.0 * damping, 1e-9);
      }
    }
    return x;
  }
};

// Its clamp holds the first two particles; the rest droops as far as the bending springs let it.
TEST(Cantilever, RestsWhereItsEnergyIsLeast) {
  const int segments = 16;
  Scene scene;
  scene.rate = 20.0;
  scene.solver.scheme = Scheme::kImplicitEuler;
  scene.solver.newton_tolerance = 1e-10;
  scene.solver.max_newton_iterations = 200;
  Rope rope;
  rope.start = {0, 0, 0};
  rope.end = {0.48, 0, 0};
  rope.segments = segments;
  rope.mass = 0.01;
  rope.stiffness = 1e5;
  rope.bend_stiffness = 1e5;
  rope.damping = 0.1;
  scene.objects = {{"rope", {1, 1, 1, 1}, rope}};
  scene.pins = {{"clamp", "rope", {0, 1}}};
  scene.effects.gravity = GravityOptions{Eigen::Vector3d(0, 0, -kGravity)};
  scene.effects.air_drag = AirDragOptions{1e-3};
  Simulation simulation(scene);
  for (int n = 0; n < 1000; ++n) ASSERT_NE(simulation.step().status, StepStatus::kFailed);
  ASSERT_LT(maxSpeed(simulation.state()), 1e-9);
  const Vectors& rest = simulation.state().positions;
  const double droop = -rest(2, segments);
  EXPECT_GT(droop, 0.1);  // neither straight on nor straight down
  EXPECT_LT(droop, 0.4);

  // From a rope that stands up at an angle, as straight as at the start.
  const Model& model = simulation.model();
  Vectors start = model.start.positions;
  for (Eigen::Index i = 2; i <= segments; ++i) {
    start.col(i) = start.col(1) + 0.03 * static_cast<double>(i - 1) * Eigen::Vector3d(0.8, 0, 0.6);
  }
  Potential potential{model.springs, model.masses, 2, 0.0, {}, {}};
  const Eigen::VectorXd least =
      potential.minimize(Eigen::Map<const Eigen::VectorXd>(start.data(), start.size()));
  ASSERT_LT(potential.gradient.norm(), 1e-10);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(potential.hessian);
  EXPECT_GT(modes.eigenvalues()[0], 0.0);
  // The softest mode turns the forces that Newton's tolerance leaves into some nanometers.
  EXPECT_LT(
      (least - Eigen::Map<const Eigen::VectorXd>(rest.data(), rest.size())).cwiseAbs().maxCoeff(),
      1e-7);
  // Half the stiffness of the softest mode, some N/m, times the square of that; stiffer modes are
  // off by less.
  EXPECT_NEAR(potential.value, energy(model, simulation.state()).total(), 1e-12);
}

}  // namespace
}  // namespace mass_spring
