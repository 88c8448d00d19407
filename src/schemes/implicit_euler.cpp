#include "schemes/implicit_euler.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "effects/effect.h"

namespace mass_spring {
namespace {

/// What a displacement is small against: the mean rest length of the springs; without springs
/// nothing is nonlinear and any length will do.
double characteristicLength(const Model& model) {
  double sum = 0.0;
  std::size_t count = 0;
  for (const Spring& s : model.springs) {
    if (s.rest_length > 0.0) {
      sum += s.rest_length;
      ++count;
    }
  }
  return count > 0 ? sum / static_cast<double>(count) : std::numeric_limits<double>::infinity();
}

/// sum over particles of weight_i |a_i|^2
double weightedSquare(const Eigen::VectorXd& weights, const Vectors& a) {
  return a.colwise().squaredNorm().dot(weights.transpose());
}

}  // namespace

ImplicitEuler::ImplicitEuler(const Model& model, const SolverOptions& options)
    : model_(model),
      options_(options),
      length_(characteristicLength(model)),
      matrix_(model.pattern),
      system_(model.pattern, options) {
  for (Vectors* vectors : {&v_, &x_, &forces_, &residual_, &right_side_, &delta_, &v_before_}) {
    vectors->setZero(3, model.particleCount());
  }
}

void ImplicitEuler::prescribeVelocities(double h, const Drive& drive, const State& state,
                                        Vectors& v) const {
  for (Eigen::Index i = 0; i < v.cols(); ++i) {
    if (drive.pinned[static_cast<std::size_t>(i)]) {
      v.col(i) = (drive.pin_positions.col(i) - state.positions.col(i)) / h;
    }
  }
}

void ImplicitEuler::assemble(double h, const Vectors& x, Projection projection,
                             SubstepReport& report) {
  const MatrixWeights weights{1.0, h, h * h};
  matrix_.setMasses(weights.mass, model_.masses);
  for (const auto& effect : model_.effects) {
    report.projected_springs += effect->addDerivatives(x, weights, projection, matrix_);
  }
  ++report.newton_iterations;
}

LinearSystem::Result ImplicitEuler::solve(SubstepReport& report, Vectors& x) {
  const LinearSystem::Result result = system_.solve(matrix_, right_side_, x);
  report.linear_iterations += result.iterations;
  report.factorizations += result.factorizations;
  return result;
}

SubstepReport ImplicitEuler::advanceLinearly(double h, const Drive& drive, State& state) {
  SubstepReport report;
  // Every damping force is linear in v, so that h f_n + h D v_n = h f(x_n, 0).
  v_.setZero();
  sumForces(model_, drive.loads, state.positions, v_, forces_);
  right_side_ = state.velocities * model_.masses.asDiagonal() + h * forces_;
  assemble(h, state.positions, Projection::kWhereNeeded, report);

  // The velocities of pinned particles are known: their columns go to the right-hand side.
  prescribeVelocities(h, drive, state, v_);
  matrix_.multiply(v_, residual_);
  delta_ = state.velocities;
  for (Eigen::Index i = 0; i < delta_.cols(); ++i) {
    const bool pinned = drive.pinned[static_cast<std::size_t>(i)];
    right_side_.col(i) =
        pinned ? Eigen::Vector3d::Zero() : Eigen::Vector3d(right_side_.col(i) - residual_.col(i));
    if (pinned) delta_.col(i).setZero();
  }
  matrix_.decouple(drive.pinned);
  const LinearSystem::Result result = solve(report, delta_);
  report.residual = result.residual;
  report.converged = result.converged;

  state.velocities = v_ + delta_;
  state.positions += h * state.velocities;
  for (Eigen::Index i = 0; i < delta_.cols(); ++i) {
    if (drive.pinned[static_cast<std::size_t>(i)]) {
      state.positions.col(i) = drive.pin_positions.col(i);
    }
  }
  return report;
}

void ImplicitEuler::evaluate(double h, const Drive& drive, const State& state) {
  x_ = state.positions + h * v_;
  sumForces(model_, drive.loads, x_, v_, forces_);
  residual_ = (v_ - state.velocities) * model_.masses.asDiagonal() - h * forces_;
  double square = 0.0;
  for (Eigen::Index i = 0; i < v_.cols(); ++i) {
    if (drive.pinned[static_cast<std::size_t>(i)]) {
      residual_.col(i).setZero();
    } else {
      square += residual_.col(i).squaredNorm() / model_.masses[i];
    }
  }
  residual_norm_ = std::sqrt(square);
}

ImplicitEuler::Potential ImplicitEuler::potential(double h, const Drive& drive,
                                                  const State& state) {
  Energy energy;
  double dissipated = 0.0;
  for (const auto& effect : model_.effects) {
    effect->addEnergy(x_, energy);
    dissipated += h * effect->dissipation(x_, v_);
  }
  double inertia = 0.0;
  for (Eigen::Index i = 0; i < v_.cols(); ++i) {
    if (drive.pinned[static_cast<std::size_t>(i)]) continue;
    inertia += 0.5 * model_.masses[i] * (v_.col(i) - state.velocities.col(i)).squaredNorm();
  }
  const double load = drive.loads ? h * drive.loads->cwiseProduct(v_).sum() : 0.0;
  Potential phi;
  phi.value = inertia + energy.elastic + energy.gravity + dissipated - load;
  // 1e-13: a few hundred roundings of the largest terms.
  phi.noise =
      1e-13 * (inertia + energy.elastic + std::abs(energy.gravity) + dissipated + std::abs(load));
  return phi;
}

bool ImplicitEuler::searchLine(double h, const Drive& drive, const State& state, bool strict) {
  const double norm_before = residual_norm_;
  const double slope = residual_.cwiseProduct(delta_).sum();
  const Potential before = potential(h, drive, state);
  v_before_ = v_;
  double alpha = 1.0;
  for (int halvings = 0; halvings < 40; ++halvings, alpha *= 0.5) {
    v_ = v_before_ + alpha * delta_;
    evaluate(h, drive, state);
    const Potential phi = potential(h, drive, state);
    // Armijo's rule; where the change drowns in rounding, and where the damping's dependence on x
    // keeps g from being the gradient of Phi, a smaller residual decides.
    if (phi.value <= before.value + 1e-4 * alpha * slope) return true;
    const bool drowned = std::abs(phi.value - before.value) <= before.noise + phi.noise;
    if ((drowned || !strict) && residual_norm_ <= (1.0 - 1e-4 * alpha) * norm_before) return true;
  }
  v_ = v_before_;
  evaluate(h, drive, state);
  return false;
}

LinearSystem::Result ImplicitEuler::solveForStep(double h, const Drive& drive, bool& exact,
                                                 SubstepReport& report) {
  right_side_ = -residual_;
  for (;;) {
    assemble(h, x_, exact ? Projection::kNone : Projection::kWhereNeeded, report);
    matrix_.decouple(drive.pinned);
    delta_.setZero();
    const LinearSystem::Result result = solve(report, delta_);
    if (!exact || !result.indefinite) return result;
    exact = false;
  }
}

SubstepReport ImplicitEuler::newton(double h, const Drive& drive, const State& state,
                                    bool from_rest) {
  SubstepReport report;
  report.converged = false;
  double free_mass = 0.0;
  for (Eigen::Index i = 0; i < v_.cols(); ++i) {
    if (!drive.pinned[static_cast<std::size_t>(i)]) free_mass += model_.masses[i];
  }
  v_ = state.velocities;
  if (from_rest) v_.setZero();
  prescribeVelocities(h, drive, state, v_);
  evaluate(h, drive, state);
  if (free_mass == 0.0) {
    report.converged = true;
    return report;
  }
  // A >= M, so h |g|_{M^-1} bounds the mass-weighted displacement that is still missing.
  const double to_displacement = h / (std::sqrt(free_mass) * length_);
  bool exact = true;
  for (int iteration = 0;; ++iteration) {
    report.residual = to_displacement * residual_norm_;
    if (report.residual <= options_.newton_tolerance && iteration > 0) {
      report.converged = true;
      return report;
    }
    if (iteration == options_.max_newton_iterations || !std::isfinite(residual_norm_)) {
      return report;
    }
    const double norm_before = residual_norm_;
    const LinearSystem::Result linear = solveForStep(h, drive, exact, report);
    const double step = to_displacement * std::sqrt(weightedSquare(model_.masses, delta_));
    const bool moved = searchLine(h, drive, state, from_rest);
    // The error before a Newton step is about that step: where the residual has reached its
    // rounding errors, a step below the tolerance ends it.
    if (linear.converged && step <= options_.newton_tolerance) {
      report.residual = std::min(step, to_displacement * residual_norm_);
      report.converged = true;
      return report;
    }
    if (!moved) return report;
    // Near the solution the exact matrix is definite, and only it converges quadratically.
    exact = exact || residual_norm_ < 0.5 * norm_before;
  }
}

SubstepReport ImplicitEuler::advance(double h, const Drive& drive, State& state) {
  SubstepReport report = newton(h, drive, state, false);
  const Potential reached = potential(h, drive, state);
  v_before_ = v_;
  v_.setZero();
  prescribeVelocities(h, drive, state, v_);
  x_ = state.positions + h * v_;
  const Potential at_rest = potential(h, drive, state);
  v_ = v_before_;
  // Staying at rest is always a choice, with Phi = |v_n|^2_M / 2 + U_n. A root of g that lies above
  // it would add energy; descending from rest cannot.
  if (!(reached.value <= at_rest.value + at_rest.noise + reached.noise)) {
    const SubstepReport again = newton(h, drive, state, true);
    report.converged = again.converged;
    report.residual = again.residual;
    report.newton_iterations += again.newton_iterations;
    report.linear_iterations += again.linear_iterations;
    report.factorizations += again.factorizations;
    report.projected_springs += again.projected_springs;
  }
  state.velocities = v_;
  for (Eigen::Index i = 0; i < v_.cols(); ++i) {
    // Where the forces overflow there is no step: the velocity says which particle it was.
    if (!std::isfinite(residual_.col(i).squaredNorm() / model_.masses[i])) {
      state.velocities.col(i).setConstant(std::numeric_limits<double>::quiet_NaN());
    }
    auto x = state.positions.col(i);
    if (drive.pinned[static_cast<std::size_t>(i)]) {
      x = drive.pin_positions.col(i);
    } else {
      x += h * v_.col(i);
    }
  }
  return report;
}

}  // namespace mass_spring
