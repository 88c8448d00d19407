#include "schemes/newton.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mass_spring {
namespace {

/// What a displacement is small against: the mean rest length of the springs, or less where an
/// effect changes faster. Where nothing is nonlinear, any length will do.
double characteristicLength(const Model& model) {
  double sum = 0.0;
  std::size_t count = 0;
  for (const Spring& s : model.springs) {
    if (s.rest_length > 0.0 && (s.stiffness > 0.0 || s.damping > 0.0)) {
      sum += s.rest_length;
      ++count;
    }
  }
  double length =
      count > 0 ? sum / static_cast<double>(count) : std::numeric_limits<double>::infinity();
  for (const auto& effect : model.effects) length = std::min(length, effect->traits().length);
  return length;
}

// The largest relative residual a linear system may keep, and that of the first iteration.
constexpr double kLoosest = 0.1;
constexpr double kFirst = 0.01;

// A step is lengthened while Phi falls still this steeply, as a share of the slope at its start.
constexpr double kSteep = 0.3;
constexpr double kLongest = 16.0;  // times the step

// The directions of damping that are held have to come nearer to those found by this factor.
constexpr double kLeastAgreement = 0.7;

// A projected matrix that leaves more than this share of the residual is not tried again.
constexpr double kCreeping = 0.5;

// What is added to an indefinite matrix, in units of the masses.
constexpr double kFewestMasses = 0.25, kMostMasses = 64.0;
constexpr double kMoreMasses = 4.0, kFewerMasses = 4.0;  // factors from one attempt to the next

}  // namespace

Newton::Newton(Workspace& workspace, const SolverOptions& options, StepSystem& system)
    : workspace_(workspace),
      model_(workspace.model()),
      options_(options),
      length_(characteristicLength(model_)),
      system_(system) {
  for (Vectors* vectors : {&x_, &forces_, &residual_, &right_side_, &delta_, &v_before_, &rest_,
                           &guess_, &held_positions_}) {
    vectors->setZero(3, model_.particleCount());
  }
  for (const auto& effect : model_.effects) {
    damped_ = damped_ || effect->traits().damping_depends_on_position;
  }
}

void Newton::evaluate(const Stage& stage, const Drive& drive, const Vectors& v) {
  x_ = stage.positions + stage.weight * v;
  Energy energy;
  double lost = 0.0;
  Sums sums{&forces_, &energy, &lost, hold_damping_ ? &held_positions_ : nullptr};
  sumForces(workspace_, drive.loads, drive.point(x_, v, stage.after), sums);
  const double dissipated = stage.weight * lost;
  double square = 0.0, inertia = 0.0, load = 0.0;
  for (Eigen::Index i = 0; i < v.cols(); ++i) {
    if (drive.isPinned(i)) {
      residual_.col(i).setZero();
      continue;
    }
    const double mass = model_.masses[i];
    const Eigen::Vector3d change = v.col(i) - stage.velocities.col(i);
    residual_.col(i) = mass * change - stage.weight * forces_.col(i);
    square += residual_.col(i).squaredNorm() / mass;
    inertia += 0.5 * mass * change.squaredNorm();
    if (drive.loads) load += stage.weight * drive.loads->col(i).dot(v.col(i));
  }
  residual_norm_ = std::sqrt(square);
  potential_.value = inertia + energy.elastic + energy.gravity + dissipated - load;
  // 1e-13: a few hundred roundings of the largest terms.
  potential_.noise = 1e-13 * (inertia + energy.elastic + std::abs(energy.gravity) +
                              std::abs(dissipated) + std::abs(load));
}

double Newton::searchLine(const Stage& stage, const Drive& drive, Vectors& v) {
  const double norm_before = residual_norm_;
  const double slope = residual_.cwiseProduct(delta_).sum();
  const Potential before = potential_;
  v_before_ = v;
  const auto stepTo = [&](double alpha) {
    v = v_before_ + alpha * delta_;
    evaluate(stage, drive, v);
  };
  double alpha = 1.0;
  for (int halvings = 0; halvings < 40; ++halvings, alpha *= 0.5) {
    stepTo(alpha);
    // Armijo's rule; where the change drowns in rounding, and where the damping's dependence on x
    // keeps g from being the gradient of Phi, a smaller residual decides.
    if (potential_.value <= before.value + 1e-4 * alpha * slope) {
      return alpha < 1.0 ? alpha : lengthen(slope, stepTo);
    }
    const bool drowned =
        std::abs(potential_.value - before.value) <= before.noise + potential_.noise;
    if ((drowned || !hold_damping_) && residual_norm_ <= (1.0 - 1e-4 * alpha) * norm_before)
      return alpha;
  }
  stepTo(0.0);
  return 0.0;
}

template <typename StepTo>
double Newton::lengthen(double slope, const StepTo& stepTo) {
  double alpha = 1.0;
  while (alpha < kLongest) {
    const double here = residual_.cwiseProduct(delta_).sum();
    if (here > kSteep * slope) break;
    // The secant's root, if there is one not too far away.
    const double longer = alpha * std::clamp(slope / (slope - here), 1.5, 4.0);
    const double value = potential_.value;
    stepTo(longer);
    if (!(potential_.value < value)) {
      stepTo(alpha);
      break;
    }
    alpha = longer;
  }
  return alpha;
}

LinearSystem::Result Newton::solveForStep(const Stage& stage, const Drive& drive, const Vectors& v,
                                          double tolerance, SubstepReport& report) {
  right_side_ = -residual_;
  const auto assemble = [&](Projection projection) {
    system_.assemble(stage.weight, drive.point(x_, v, stage.after),
                     hold_damping_ ? &held_positions_ : nullptr, projection, report);
    system_.decouple(drive.pinned);
  };
  const auto solve = [&] {
    delta_.setZero();
    return system_.solve(right_side_, tolerance, delta_, report);
  };
  assemble(Projection::kNone);
  added_masses_ = added_masses_ > kFewestMasses ? added_masses_ / kFewerMasses : 0.0;
  if (added_masses_ > 0.0) system_.addMasses(added_masses_, report);
  LinearSystem::Result result = solve();
  while (result.indefinite && crept_ && added_masses_ < kMostMasses) {
    const double more = std::max(kFewestMasses, kMoreMasses * added_masses_);
    system_.addMasses(more - added_masses_, report);
    added_masses_ = more;
    result = solve();
  }
  projected_ = result.indefinite;
  if (!projected_) return result;
  assemble(Projection::kWhereNeeded);
  result = solve();
  // A projected matrix is definite but for rounding. A heavier one still leads downhill.
  for (double share = 1e-14; result.indefinite && share < 1e-2; share *= 100.0) {
    system_.shift(share);
    result = solve();
  }
  return result;
}

bool Newton::iterate(const Stage& stage, const Drive& drive, Vectors& v, SubstepReport& report) {
  evaluate(stage, drive, v);
  double lightest = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < v.cols(); ++i) {
    if (!drive.isPinned(i)) lightest = std::min(lightest, model_.masses[i]);
  }
  if (!std::isfinite(lightest)) return true;  // all are pinned: nothing is unknown

  // A >= M, so w |g|_{M^-1} bounds the mass-weighted displacement that is still missing.
  const double residual_scale = stage.weight / (std::sqrt(lightest) * length_);
  const double floor = std::min(options_.linear_tolerance, kLoosest);
  added_masses_ = 0.0;
  crept_ = false;
  double linear_tolerance = std::max(kFirst, floor);
  double step_before = 0.0;  // of the iteration before, if that went all the way
  for (int iteration = 0;; ++iteration) {
    const double bound = residual_scale * residual_norm_;
    if (bound <= options_.newton_tolerance && iteration > 0) {
      report.residual = std::max(report.residual, bound);
      return true;
    }
    if (iteration == options_.max_newton_iterations || !std::isfinite(residual_norm_)) {
      report.residual = std::max(report.residual, bound);
      return false;
    }
    const double norm_before = residual_norm_;
    const LinearSystem::Result linear = solveForStep(stage, drive, v, linear_tolerance, report);
    const double step =
        stage.weight * std::sqrt(delta_.colwise().squaredNorm().maxCoeff()) / length_;
    const double share = searchLine(stage, drive, v);
    // Where steps shrink by a factor q, q / (1 - q) of the last one is still missing (Hairer and
    // Wanner 1996, IV.8); a step that is itself below the tolerance ends the iteration also where
    // the residual has reached its rounding errors.
    const double q = step_before > 0.0 ? step / step_before : 1.0;
    const double missing = q < 0.5 ? step * std::max(q / (1.0 - q), linear.residual) : step;
    if (linear.converged && (share == 1.0 || share == 0.0) &&
        missing <= options_.newton_tolerance) {
      report.residual = std::max(report.residual, missing);
      return true;
    }
    if (share == 0.0) {
      report.residual = std::max(report.residual, residual_scale * residual_norm_);
      return false;
    }
    const double reduction = residual_norm_ / norm_before;
    linear_tolerance = std::clamp(0.9 * reduction * reduction, floor, kLoosest);
    step_before = share == 1.0 ? step : 0.0;
    crept_ = crept_ || (projected_ && reduction > kCreeping);
  }
}

bool Newton::iterateHolding(const Stage& stage, const Drive& drive, Vectors& v,
                            SubstepReport& report) {
  double moved_before = std::numeric_limits<double>::infinity();
  for (;;) {
    guess_ = v;
    if (!descend(stage, drive, v, v, report)) return false;
    const double moved =
        stage.weight * std::sqrt((v - guess_).colwise().squaredNorm().maxCoeff()) / length_;
    if (moved <= options_.newton_tolerance) return true;
    if (moved > kLeastAgreement * moved_before) return false;
    moved_before = moved;
  }
}

bool Newton::descend(const Stage& stage, const Drive& drive, const Vectors& held, Vectors& v,
                     SubstepReport& report) {
  held_positions_ = stage.positions + stage.weight * held;
  hold_damping_ = true;
  const bool converged = iterate(stage, drive, v, report);
  hold_damping_ = false;
  return converged;
}

void Newton::solve(const Stage& stage, const Drive& drive, Vectors& v, SubstepReport& report) {
  const double residual = report.residual;
  if (!iterate(stage, drive, v, report)) {
    const double missed = report.residual;
    report.residual = residual;
    if (!(damped_ && v.allFinite() && iterateHolding(stage, drive, v, report))) {
      report.residual = std::max(report.residual, missed);
      report.converged = false;
    }
  }
  markOverflow(v);
}

void Newton::solveBelowRest(const Stage& stage, const Drive& drive, Vectors& v,
                            SubstepReport& report) {
  rest_ = v;
  for (Eigen::Index i = 0; i < v.cols(); ++i) {
    if (!drive.isPinned(i)) rest_.col(i).setZero();
  }
  evaluate(stage, drive, rest_);
  const Potential at_rest = potential_;
  bool converged = iterate(stage, drive, v, report);
  // A root of g that lies above rest would add energy; descending from rest cannot.
  if (!(potential_.value <= at_rest.value + at_rest.noise + potential_.noise)) {
    v = rest_;
    converged = descend(stage, drive, rest_, v, report);
  }
  if (!converged) report.converged = false;
  markOverflow(v);
}

void Newton::markOverflow(Vectors& v) const {
  // Where the forces overflow there is no step: the velocity says which particle it was.
  for (Eigen::Index i = 0; i < v.cols(); ++i) {
    if (!std::isfinite(residual_.col(i).squaredNorm() / model_.masses[i])) {
      v.col(i).setConstant(std::numeric_limits<double>::quiet_NaN());
    }
  }
}

}  // namespace mass_spring
