#include "schemes/stage_scheme.h"

#include <cmath>

namespace mass_spring {
namespace {

const double kRoot2 = std::sqrt(2.0);

const StageTable kImplicitEulerTable = {1, false, 1.0, {}, true, {}};
const StageTable kMidpointTable = {1, false, 0.5, {}, false, {}};
// TR-BDF2 with gamma = 2 - sqrt(2): the trapezoidal rule to t + gamma h, then BDF2 over both parts.
// Written as a Runge-Kutta method with an embedded one of order 3: Hosea and Shampine, "Analysis
// and implementation of TR-BDF2", Applied Numerical Mathematics 20 (1996).
const double kBeta = 1.0 - 1.0 / kRoot2;
const double kW = kRoot2 / 4.0;
const StageTable kTrBdf2Table = {
    3,     true,
    kBeta, {{{}, {kBeta, 0.0}, {kW, kW}}},
    true,  {(1.0 - kW) / 3.0 - kW, (3.0 * kW + 1.0) / 3.0 - kW, kBeta / 3.0 - kBeta}};

// bdf2 itself has no estimate.
const StageTable kStartTable = [] {
  StageTable table = kTrBdf2Table;
  table.error = {};
  return table;
}();

// BDF2 with steps that grow by more than 1 + sqrt(2) is unstable (Hairer, Norsett and Wanner 1993,
// III.5).
constexpr double kLargestGrowth = 2.0;

}  // namespace

StageScheme::StageScheme(Workspace& workspace, const SolverOptions& options, StepSystem& system)
    : workspace_(workspace), newton_(workspace, options, system) {
  const auto resize = [&](auto&... vectors) {
    (vectors.setZero(3, workspace.model().particleCount()), ...);
  };
  const bool two_step = options.scheme == Scheme::kBdf2;
  const bool estimates = options.scheme == Scheme::kTrBdf2;
  const std::size_t stages = two_step || estimates ? 3 : 1;
  resize(base_positions_, base_velocities_, v_);
  for (std::size_t i = 0; i < stages; ++i) resize(stage_velocities_[i], stage_accelerations_[i]);
  if (two_step) resize(before_.positions, before_.velocities, kept_.positions, kept_.velocities);
  if (estimates) {
    filter_.emplace(workspace, system);
    resize(error_positions_, error_velocities_);
  }
}

SubstepReport StageScheme::advance(Scheme scheme, double h, const Drive& drive, State& state) {
  SubstepReport report;
  switch (scheme) {
    case Scheme::kImplicitMidpoint:
      advanceStages(kMidpointTable, false, h, drive, state, report);
      break;
    case Scheme::kBdf2:
      advanceTwoStep(h, drive, state, report);
      break;
    case Scheme::kTrBdf2:
      advanceStages(kTrBdf2Table, false, h, drive, state, report);
      break;
    default:
      advanceStages(kImplicitEulerTable, true, h, drive, state, report);
  }
  return report;
}

void StageScheme::restore() {
  before_.step = kept_.step;
  if (kept_.step == 0.0) return;
  before_.positions = kept_.positions;
  before_.velocities = kept_.velocities;
}

void StageScheme::keep() {
  if (before_.step == 0.0) return;
  kept_.step = before_.step;
  kept_.positions.swap(before_.positions);
  kept_.velocities.swap(before_.velocities);
}

void StageScheme::advanceStages(const StageTable& table, bool below_rest, double h,
                                const Drive& drive, State& state, SubstepReport& report) {
  const double w = table.beta * h;
  v_ = state.velocities;
  for (int i = 0; i < table.stages; ++i) {
    const auto stage = static_cast<std::size_t>(i);
    Vectors& accelerations = stage_accelerations_[stage];
    const double after = table.at(i) * h;
    if (i == 0 && table.explicit_first) {
      sumForces(workspace_, drive.loads, drive.point(state.positions, v_, after), accelerations);
      accelerations.array().rowwise() /= workspace_.model().masses.transpose().array();
    } else {
      base_positions_ = state.positions;
      base_velocities_ = state.velocities;
      for (std::size_t j = 0; j < stage; ++j) {
        base_positions_ += h * table.below[stage][j] * stage_velocities_[j];
        base_velocities_ += h * table.below[stage][j] * stage_accelerations_[j];
      }
      const Stage implicit{w, after, base_positions_, base_velocities_};
      if (below_rest) {
        newton_.solveBelowRest(implicit, drive, v_, report);
      } else {
        newton_.solve(implicit, drive, v_, report);
      }
      accelerations = (v_ - base_velocities_) / w;
    }
    clearPinned(drive, accelerations);
    stage_velocities_[stage] = v_;
  }
  if (table.ends_with_last) {
    state.positions = base_positions_ + w * v_;
    state.velocities = v_;
    if (table.error[0] != 0.0 && report.converged) {
      estimateError(table, h, drive, state, report);
    }
  } else {
    state.positions += h * stage_velocities_[0];
    state.velocities += h * stage_accelerations_[0];
  }
}

void StageScheme::advanceTwoStep(double h, const Drive& drive, State& state,
                                 SubstepReport& report) {
  const bool start = before_.step == 0.0 || h > kLargestGrowth * before_.step;
  const double growth = start ? 1.0 : h / before_.step;
  if (!start) {
    // y_{n+1} = y_n + growth^2 / (1 + 2 growth) (y_n - y_{n-1}) + beta h y'_{n+1}
    const double extrapolation = growth * growth / (1.0 + 2.0 * growth);
    base_positions_ = state.positions + extrapolation * (state.positions - before_.positions);
    base_velocities_ = state.velocities + extrapolation * (state.velocities - before_.velocities);
  }
  before_.step = h;
  before_.positions = state.positions;
  before_.velocities = state.velocities;
  if (start) {
    advanceStages(kStartTable, false, h, drive, state, report);
    return;
  }
  const double w = h * (1.0 + growth) / (1.0 + 2.0 * growth);
  for (Eigen::Index i = 0; i < v_.cols(); ++i) {
    if (!drive.isPinned(i)) continue;
    base_positions_.col(i) = state.positions.col(i) + (h - w) * state.velocities.col(i);
  }
  v_ = state.velocities;
  newton_.solve({w, h, base_positions_, base_velocities_}, drive, v_, report);
  state.positions = base_positions_ + w * v_;
  state.velocities = v_;
}

void StageScheme::estimateError(const StageTable& table, double h, const Drive& drive,
                                const State& end, SubstepReport& report) {
  if (report.newton_iterations == 0) {  // nothing was unknown
    report.estimated_error = 0.0;
    return;
  }
  error_positions_.setZero();
  error_velocities_.setZero();
  for (std::size_t i = 0; i < static_cast<std::size_t>(table.stages); ++i) {
    error_positions_ += h * table.error[i] * stage_velocities_[i];
    error_velocities_ += h * table.error[i] * stage_accelerations_[i];
  }
  report.estimated_error =
      filter_->apply(table.beta * h, drive, drive.point(end.positions, end.velocities, h),
                     error_positions_, error_velocities_, report);
}

}  // namespace mass_spring
