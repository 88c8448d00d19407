#include "schemes/step_system.h"

#include <cmath>
#include <utility>

namespace mass_spring {

StepSystem::StepSystem(const Model& model, const SolverOptions& options,
                       std::vector<const Effect*> effects)
    : model_(model),
      effects_(std::move(effects)),
      matrix_(model.pattern, model.threads.get()),
      system_(model, options) {}

StepSystem::StepSystem(const Model& model, const SolverOptions& options)
    : StepSystem(model, options, {}) {
  for (const auto& effect : model.effects) effects_.push_back(effect.get());
}

void StepSystem::assemble(double w, const Vectors& x, const Vectors& x_damping, const Vectors& v,
                          Projection projection, SubstepReport& report) {
  matrix_.setMasses(1.0, model_.masses);
  const auto add = [&](const Vectors& positions, const MatrixWeights& weights) {
    for (const Effect* effect : effects_) {
      report.projected_springs +=
          effect->addDerivatives(positions, v, weights, projection, matrix_);
    }
  };
  if (&x == &x_damping) {
    add(x, {1.0, w, w * w});
  } else {
    add(x, {1.0, 0.0, w * w});
    add(x_damping, {1.0, w, 0.0});
  }
  ++report.newton_iterations;
}

void StepSystem::linearize(double w, const State& state, Vectors& forces, SubstepReport& report) {
  matrix_.setMasses(1.0, model_.masses);
  forces.setZero();
  for (const Effect* effect : effects_) {
    report.projected_springs +=
        effect->linearize(state.positions, state.velocities, w, matrix_, forces);
  }
  ++report.newton_iterations;
}

void StepSystem::decouple(const std::vector<char>& pinned) {
  matrix_.decouple(pinned);
  system_.prepare(matrix_);
}

void StepSystem::shift(double share) {
  matrix_.shift(share);
  system_.prepare(matrix_);
}

void StepSystem::addMasses(double share, SubstepReport& report) {
  for (std::uint32_t i = 0; i < model_.particleCount(); ++i) {
    matrix_.diagonal()[i] += SymmetricBlock::isotropic(share * model_.masses[i]);
  }
  system_.prepare(matrix_);
  ++report.newton_iterations;
}

LinearSystem::Result StepSystem::solve(const Vectors& b, double tolerance, Vectors& x,
                                       SubstepReport& report) {
  const LinearSystem::Result result = system_.solve(b, tolerance, x);
  report.linear_iterations += result.iterations;
  report.factorizations += result.factorizations;
  return result;
}

void clearPinned(const Drive& drive, Vectors& a) {
  for (Eigen::Index i = 0; i < a.cols(); ++i) {
    if (drive.isPinned(i)) a.col(i).setZero();
  }
}

double rootMeanSquare(const Drive& drive, const Vectors& a) {
  double sum = 0.0;
  Eigen::Index free = 0;
  for (Eigen::Index i = 0; i < a.cols(); ++i) {
    if (drive.isPinned(i)) continue;
    sum += a.col(i).squaredNorm();
    ++free;
  }
  return free > 0 ? std::sqrt(sum / static_cast<double>(free)) : 0.0;
}

}  // namespace mass_spring
