#include "scheme_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace mass_spring {
namespace {

// Nanoseconds per spring, measured (benchmark/README.md): one evaluation of the forces with the
// update of the particles, and one step of tr_bdf2 with all its Newton iterations.
constexpr double kEvaluation = 4.0;
constexpr double kImplicitStep = 1500.0;
// The error of tr_bdf2 in one step of 1/60 s [m], on swinging cloth, from which the number of its
// sub-steps for an accuracy is guessed.
constexpr double kTypicalError = 0.01;

constexpr int kPowerIterations = 30;
constexpr double kLargestSubsteps = 100000;

template <typename Coefficient>
double boundEigenvalue(const Model& model, Coefficient coefficient) {
  const Eigen::Index n = model.masses.size();
  Eigen::VectorXd y = Eigen::VectorXd::Ones(n), next(n);
  double bound = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < kPowerIterations; ++iteration) {
    next.setZero();
    for (const Spring& s : model.springs) {
      const double part = s.*coefficient * (y[s.i] + y[s.j]);
      next[s.i] += part;
      next[s.j] += part;
    }
    next.array() /= model.masses.array();
    bound = std::min(bound, (next.array() / y.array()).maxCoeff());
    const double largest = next.maxCoeff();
    if (!(largest > 0.0)) return 0.0;
    // Every positive y gives a bound: parts of the scene that are much slower stay in it.
    y = (next / largest).cwiseMax(1e-12);
  }
  return bound;
}

/// The positive root of a h^2 + b h = 1.
double positiveRoot(double a, double b) {
  if (a == 0.0 && b == 0.0) return std::numeric_limits<double>::infinity();
  return 2.0 / (b + std::sqrt(b * b + 4.0 * a));
}

}  // namespace

SpectrumBounds boundSpectrum(const Model& model) {
  return {std::sqrt(boundEigenvalue(model, &Spring::stiffness)),
          boundEigenvalue(model, &Spring::damping)};
}

double stableSymplecticStep(const SpectrumBounds& bounds) {
  return positiveRoot(bounds.frequency * bounds.frequency / 4.0, bounds.damping / 2.0);
}

double stableRk4Step(const SpectrumBounds& bounds) {
  return positiveRoot(bounds.frequency * bounds.frequency / (2.8 * 2.8), bounds.damping / 2.7);
}

SchemeChoice chooseScheme(const Scene& scene, const Model& model) {
  SchemeChoice choice{scene.solver, ""};
  if (scene.solver.scheme != Scheme::kAuto) return choice;
  const SpectrumBounds bounds = boundSpectrum(model);
  const bool estimate = scene.solver.accuracy.has_value();
  const Scheme explicit_scheme = estimate ? Scheme::kRk4 : Scheme::kSymplecticEuler;
  const double stable = estimate ? stableRk4Step(bounds) : stableSymplecticStep(bounds);
  const double h = 1.0 / scene.rate;
  const double substeps = std::max<double>(scene.solver.substeps, std::ceil(h / stable));
  const double explicit_cost = substeps * (estimate ? 4.0 : 1.0) * kEvaluation;
  const double implicit_substeps =
      estimate ? std::max(1.0, 60.0 * h * std::sqrt(kTypicalError / *scene.solver.accuracy))
               : scene.solver.substeps;
  const double implicit_cost = implicit_substeps * kImplicitStep;

  const bool is_explicit = explicit_cost <= implicit_cost && substeps <= kLargestSubsteps;
  if (is_explicit) {
    choice.options.scheme = explicit_scheme;
    choice.options.substeps = static_cast<int>(substeps);
  } else {
    choice.options.scheme = Scheme::kTrBdf2;
  }
  std::ostringstream reason;
  reason.precision(3);
  reason << "auto chose " << info(choice.options.scheme).name << ": " << info(explicit_scheme).name
         << " is stable up to " << stable << " s (frequencies up to " << bounds.frequency
         << " rad/s) and would cost " << explicit_cost << " ns per spring and step in " << substeps
         << " sub-steps, tr_bdf2 about " << implicit_cost << " ns";
  choice.reason = reason.str();
  return choice;
}

}  // namespace mass_spring
