#include "schemes/rosenbrock.h"

#include <algorithm>
#include <cmath>

namespace mass_spring {
namespace {

const RosenbrockTable kLinearImplicitEulerTable = {
    1, 1.0, {}, {}, {1.0, 0.0, 0.0}, {}, {1.0, 0.0, 0.0}, {}, false};

// ROS3: order 3, L-stable, embedded order 2; stages 1 and 2 share their function values. Sandu et
// al., "Benchmarking stiff ODE solvers for atmospheric chemistry problems II: Rosenbrock solvers",
// Atmospheric Environment 31 (1997).
const RosenbrockTable kRos3Table = {
    3,
    0.43586652150845899941601945119356,
    {{{}, {1.0, 0.0}, {1.0, 0.0}}},
    {{{},
      {-1.0156171083877702091975600115545, 0.0},
      {4.0759956452537699824805835358067, 9.2076794298330791242156818474003}}},
    {1.0, 6.1697947043828245592553615689730, -0.4277225654321857332623837380651},
    {0.5, -2.9079558716805469821718236208017, 0.2235406989781156962736090927619},
    {0.0, 0.43586652150845899941601945119356, 0.43586652150845899941601945119356},
    {0.43586652150845899941601945119356, 0.24291996454816804366592249683314,
     2.1851380027664058511513169485832},
    true};

// Forces are differentiated over this share of a step: far above rounding, and far below what
// would take a scheme of order 3 its order.
constexpr double kRateShare = 1e-4;

// The step matrix is so near the exact derivative that more rounds mean they do not lead there.
constexpr int kMaxRounds = 12;
// What one round leaves: less would be lost to the difference of the two matrices.
constexpr double kRoundTolerance = 1e-3;

}  // namespace

Rosenbrock::Rosenbrock(Workspace& workspace, const SolverOptions& options, StepSystem& system)
    : workspace_(workspace), model_(workspace.model()), options_(options), system_(system) {
  const auto resize = [&](auto&... vectors) { (vectors.setZero(3, model_.particleCount()), ...); };
  resize(x_, v_, rate_, right_side_, u_, product_, change_, still_);
  const int stages = options.scheme == Scheme::kRos3 ? kRos3Table.stages : 1;
  for (std::size_t i = 0; i < static_cast<std::size_t>(stages); ++i) resize(p_[i], q_[i]);
}

SubstepReport Rosenbrock::advance(Scheme scheme, double h, const Drive& drive, State& state) {
  SubstepReport report;
  advance(scheme == Scheme::kRos3 ? kRos3Table : kLinearImplicitEulerTable, h, drive, state,
          report);
  return report;
}

void Rosenbrock::advance(const RosenbrockTable& table, double h, const Drive& drive, State& state,
                         SubstepReport& report) {
  const double w = table.gamma * h;
  const Point start = drive.point(state.positions, state.velocities, 0.0);
  const bool timed = table.exact && dependsOnTime(workspace_, start);
  if (table.exact) {
    system_.assemble(w, start, nullptr, Projection::kWhereNeeded, report);
    if (timed) findForcesRate(h, drive, state);
  }
  bool looked_again = table.exact;
  for (std::size_t i = 0; i < static_cast<std::size_t>(table.stages); ++i) {
    const double after = table.alpha[i] * h;
    x_ = state.positions;
    v_ = state.velocities;
    for (std::size_t j = 0; j < i; ++j) {
      if (table.a[i][j] == 0.0) continue;
      x_ += table.a[i][j] * p_[j];
      v_ += table.a[i][j] * q_[j];
    }
    rate_ = v_;
    for (std::size_t j = 0; j < i; ++j) rate_ += (table.c[i][j] / h) * p_[j];

    // p / w - q = x', M q / w + K p + D q = M v'. With the unknown u = p / w:
    //   (M + w D + w^2 K) u = M (x' + w v') + w D x'.
    if (!table.exact) {
      // One stage, in which x' = v.
      system_.linearize(w, drive.point(state.positions, state.velocities, after), right_side_,
                        report);
      if (drive.loads) right_side_ += *drive.loads;
    } else {
      sumForces(workspace_, drive.loads, drive.point(x_, v_, after), right_side_);
      if (timed) right_side_ += table.gamma_rate[i] * h * forces_rate_;
      product_.setZero();
      addForceDerivative(workspace_, start, still_, rate_, product_);
      right_side_ -= product_;
    }
    right_side_ *= w;
    change_ = rate_;
    for (std::size_t j = 0; j < i; ++j) change_ += (w * table.c[i][j] / h) * q_[j];
    right_side_ += change_ * model_.masses.asDiagonal();

    // Pinned particles: q = 0, so that u = x'.
    u_ = rate_;
    if (table.exact) {
      if (i == 0) system_.decouple(drive.pinned);
      solveExactly(w, drive, state, u_, report);
    } else {
      solve(drive, u_, report);
    }
    p_[i] = w * u_;
    q_[i] = u_ - rate_;
    clearPinned(drive, q_[i]);
    if (!looked_again) {
      looked_again = true;
      x_ = state.positions + p_[i];
      // If not, the same stage, better informed.
      if (!system_.linearizationCovered(drive.point(x_, u_, after))) --i;
    }
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(table.stages); ++i) {
    state.positions += table.m[i] * p_[i];
    state.velocities += table.m[i] * q_[i];
  }
  if (table.error[0] != 0.0) {
    // Each U_i has been through (I - w J)^-1: nothing stiff is left in their sum.
    change_.setZero();
    for (std::size_t i = 0; i < static_cast<std::size_t>(table.stages); ++i) {
      change_ += table.error[i] * p_[i];
    }
    report.estimated_error = rootMeanSquare(drive, change_);
  }
}

void Rosenbrock::findForcesRate(double h, const Drive& drive, const State& state) {
  if (forces_rate_.size() == 0) forces_rate_.setZero(3, state.positions.cols());
  const double ahead = kRateShare * h;
  sumForces(workspace_, nullptr, drive.point(state.positions, state.velocities, 0.0), product_);
  sumForces(workspace_, nullptr, drive.point(state.positions, state.velocities, ahead),
            forces_rate_);
  forces_rate_ = (forces_rate_ - product_) / ahead;
}

void Rosenbrock::solve(const Drive& drive, Vectors& u, SubstepReport& report) {
  // The columns of pinned particles go to the right-hand side.
  for (Eigen::Index i = 0; i < u.cols(); ++i) {
    if (drive.isPinned(i)) {
      change_.col(i).setZero();
      still_.col(i) = u.col(i);
    } else {
      change_.col(i) = u.col(i);
    }
  }
  if (!still_.isZero(0.0)) {
    system_.multiply(still_, product_);
    right_side_ -= product_;
  }
  clearPinned(drive, right_side_);
  system_.decouple(drive.pinned);
  const LinearSystem::Result result =
      system_.solve(right_side_, options_.linear_tolerance, change_, report);
  report.residual = result.residual;
  report.converged = result.converged;
  u = still_ + change_;
  still_.setZero();
}

void Rosenbrock::solveExactly(double w, const Drive& drive, const State& state, Vectors& u,
                              SubstepReport& report) {
  product_ = right_side_;
  clearPinned(drive, product_);
  const double goal = options_.linear_tolerance * product_.norm();
  double norm_before = 0.0;
  for (int round = 0;; ++round) {
    // right_side - (M + w D + w^2 K) u, exactly.
    x_ = w * u;
    product_.setZero();
    addForceDerivative(workspace_, drive.point(state.positions, state.velocities, 0.0), x_, u,
                       product_);
    product_ = right_side_ - u * model_.masses.asDiagonal() + w * product_;
    clearPinned(drive, product_);
    const double norm = product_.norm();
    const bool finite = std::isfinite(norm) && std::isfinite(goal);
    const bool reached = finite && norm <= goal;
    // Without a right-hand side the solution is zero, and so are both numbers.
    if (reached || !finite || round == kMaxRounds || (round > 1 && norm > 0.5 * norm_before)) {
      if (norm > 0.0) {
        report.residual = std::max(report.residual, options_.linear_tolerance * norm / goal);
      }
      report.converged = report.converged && reached;
      return;
    }
    norm_before = norm;
    change_.setZero();
    system_.solve(product_, kRoundTolerance, change_, report);
    u += change_;
  }
}

}  // namespace mass_spring
