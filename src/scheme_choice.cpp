#include "scheme_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <vector>

#include "effects/effect.h"

namespace mass_spring {
namespace {

// Nanoseconds, measured (benchmark/README.md): one evaluation of the forces with the update of the
// particles, and one step of tr_bdf2 with all its Newton iterations.
struct Cost {
  double alone, per_spring;
};
constexpr Cost kEvaluation = {300.0, 4.0}, kImplicitStep = {3000.0, 1000.0};
// The estimated error of a second in steps of 1/60 s [m], and the power of the step that it falls
// by, from which the sub-steps for an accuracy are guessed: geometric means over the scenes of
// benchmark/error_control.cpp for explicit schemes, whose steps are short for the sake of
// stability; over the stiff ones of docs/accuracy (0.015 and 0.1) for tr_bdf2, whose steps do not
// resolve what is fast and so lose an order.
struct ErrorGuess {
  double error, order;
};
constexpr ErrorGuess kVerletError = {0.01, 2.0}, kRk4Error = {0.01, 4.0},
                     kImplicitError = {0.04, 1.0};

constexpr double kLargestSubsteps = 100000;

/// @param alone  per particle, what acts on it whatever the others do
template <typename Coefficient>
double boundEigenvalue(const Model& model, Coefficient coefficient, const Eigen::VectorXd& alone) {
  const Eigen::Index n = model.masses.size();
  Eigen::VectorXd y = Eigen::VectorXd::Ones(n), next(n);
  double bound = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < kPowerIterations; ++iteration) {
    next = alone.cwiseProduct(y);
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
  Eigen::VectorXd stiffness = Eigen::VectorXd::Zero(model.masses.size()), damping = stiffness;
  for (const auto& effect : model.effects) effect->addBounds(stiffness, damping);
  return {std::sqrt(boundEigenvalue(model, &Spring::stiffness, stiffness)),
          boundEigenvalue(model, &Spring::damping, damping)};
}

double stableSymplecticStep(const SpectrumBounds& bounds) {
  return positiveRoot(bounds.frequency * bounds.frequency / 4.0, bounds.damping / 2.0);
}

double stableVerletStep(const SpectrumBounds& bounds) {
  return positiveRoot(bounds.frequency * bounds.frequency / 4.0, bounds.damping);
}

double stableRk4Step(const SpectrumBounds& bounds) {
  return positiveRoot(bounds.frequency * bounds.frequency / (2.8 * 2.8), bounds.damping / 2.7);
}

SchemeChoice chooseScheme(const Scene& scene, const Model& model) {
  SchemeChoice choice{scene.solver, ""};
  const std::optional<double> accuracy = controlledAccuracy(scene.solver);
  choice.options.accuracy = accuracy;
  if (scene.solver.scheme != Scheme::kAuto) return choice;
  const SpectrumBounds bounds = boundSpectrum(model);
  const double h = 1.0 / scene.rate;
  const auto springs = static_cast<double>(model.springs.size());

  struct Candidate {
    Scheme scheme;
    double stable;  // s
    Cost cost;      // of a sub-step
    ErrorGuess guess;
    double substeps = 0.0, total = 0.0;
  };
  const Cost four = {4.0 * kEvaluation.alone, 4.0 * kEvaluation.per_spring};
  std::vector<Candidate> candidates = {
      {Scheme::kTrBdf2, std::numeric_limits<double>::infinity(), kImplicitStep, kImplicitError}};
  const double stable = accuracy ? stableVerletStep(bounds) : stableSymplecticStep(bounds);
  candidates.push_back({Scheme::kSymplecticEuler, stable, kEvaluation, kVerletError});
  if (accuracy) candidates.push_back({Scheme::kRk4, stableRk4Step(bounds), four, kRk4Error});
  for (Candidate& c : candidates) {
    c.substeps = std::max<double>(scene.solver.substeps, std::ceil(h / c.stable));
    double taken = c.substeps;
    if (accuracy) {
      const double refined = std::pow(c.guess.error / *accuracy, 1.0 / c.guess.order);
      taken = std::max(taken, 60.0 * h * refined);
    }
    c.total = taken * (c.cost.alone + c.cost.per_spring * springs);
  }
  const Candidate& implicit = candidates[0];
  Candidate best = implicit;
  for (const Candidate& c : candidates) {
    if (c.total <= best.total && c.substeps <= kLargestSubsteps) best = c;
  }
  choice.options.scheme = best.scheme;
  // Verlet's own number follows the springs from step to step.
  if (!accuracy || best.scheme == Scheme::kRk4) {
    choice.options.substeps = static_cast<int>(best.substeps);
  }
  std::ostringstream reason;
  reason.precision(3);
  reason << "auto chose " << name(best.scheme) << " (frequencies up to " << bounds.frequency
         << " rad/s):";
  for (const Candidate& c : candidates) {
    reason << (c.scheme == implicit.scheme ? " " : ", ") << name(c.scheme) << " would cost about "
           << 1e-3 * c.total << " us per step";
    if (std::isfinite(c.stable)) {
      reason << ", stable up to " << c.stable << " s, in " << c.substeps << " sub-steps";
    }
  }
  choice.reason = reason.str();
  return choice;
}

}  // namespace mass_spring
