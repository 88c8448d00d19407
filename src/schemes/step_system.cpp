#include "schemes/step_system.h"

#include <cmath>
#include <utility>

namespace mass_spring {

StepSystem::StepSystem(Workspace& workspace, const SolverOptions& options,
                       const std::function<bool(const Effect&)>& part)
    : workspace_(workspace),
      matrix_(workspace.model().pattern, &workspace.threads()),
      system_(workspace, options) {
  for (const Workspace::Part& each : workspace.parts()) {
    if (part(*each.effect)) parts_.push_back(&each);
  }
}

StepSystem::StepSystem(Workspace& workspace, const SolverOptions& options)
    : StepSystem(workspace, options, [](const Effect&) { return true; }) {}

void StepSystem::assemble(double w, const Point& point, const Vectors* damping_positions,
                          Projection projection, SubstepReport& report) {
  matrix_.setMasses(1.0, workspace_.model().masses);
  const auto add = [&](const Point& at, const MatrixWeights& weights) {
    for (const Workspace::Part* part : parts_) {
      report.projected_springs +=
          part->effect->addDerivatives(at, part->scratch.get(), weights, projection, matrix_);
    }
  };
  if (damping_positions == nullptr) {
    add(point, {1.0, w, w * w});
  } else {
    add(point, {1.0, 0.0, w * w});
    add({*damping_positions, point.velocities, point.time, point.effects}, {1.0, w, 0.0});
  }
  ++report.newton_iterations;
}

void StepSystem::linearize(double w, const Point& point, Vectors& forces, SubstepReport& report) {
  matrix_.setMasses(1.0, workspace_.model().masses);
  forces.setZero();
  for (const Workspace::Part* part : parts_) {
    report.projected_springs +=
        part->effect->linearize(point, part->scratch.get(), w, matrix_, forces);
  }
  ++report.newton_iterations;
}

bool StepSystem::linearizationCovered(const Point& end) {
  bool covered = true;
  for (const Workspace::Part* part : parts_) {
    if (part->foreseeing == nullptr) continue;
    covered = part->foreseeing->linearizationCovered(end, part->scratch.get()) && covered;
  }
  return covered;
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
  const Model& model = workspace_.model();
  for (std::uint32_t i = 0; i < model.particleCount(); ++i) {
    matrix_.diagonal()[i] += SymmetricBlock::isotropic(share * model.masses[i]);
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
