#include "plain_eigen.h"

#include <algorithm>
#include <limits>

namespace mass_spring {

PlainEigen::PlainEigen(const Model& model, const Eigen::Vector3d& gravity,
                       const std::vector<char>& pinned, double h, Solver solver, double tolerance)
    : model_(model),
      gravity_(gravity),
      h_(h),
      solver_(solver),
      unknown_(model.particleCount(), -1),
      right_side_(3, model.particleCount()) {
  int free = 0;
  for (std::uint32_t i = 0; i < model.particleCount(); ++i) {
    if (!pinned[i]) unknown_[i] = free++;
  }
  b_.resize(3 * free);
  matrix_.resize(3 * free, 3 * free);
  conjugate_gradient_.setTolerance(tolerance);
  conjugate_gradient_.setMaxIterations(100000);
}

void PlainEigen::addBlock(std::uint32_t i, std::uint32_t j, const Eigen::Matrix3d& block) {
  if (unknown_[i] < 0 || unknown_[j] < 0) return;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      triplets_.emplace_back(3 * unknown_[i] + row, 3 * unknown_[j] + column, block(row, column));
    }
  }
}

void PlainEigen::assemble(const State& state) {
  // As much as compressed springs could take from each particle's mass: where that is more than
  // there is, they are projected.
  Eigen::VectorXd taken = Eigen::VectorXd::Zero(model_.particleCount());
  for (const Spring& s : model_.springs) {
    const double length = (state.positions.col(s.j) - state.positions.col(s.i)).norm();
    const double compression = std::max(s.rest_length / length - 1.0, 0.0);
    taken[s.i] += 2.0 * h_ * h_ * s.stiffness * compression;
    taken[s.j] += 2.0 * h_ * h_ * s.stiffness * compression;
  }
  triplets_.clear();
  Eigen::VectorXd sizes = Eigen::VectorXd::Zero(model_.particleCount());  // of the terms of b
  for (std::uint32_t i = 0; i < model_.particleCount(); ++i) {
    const double mass = model_.masses[i];
    addBlock(i, i, mass * Eigen::Matrix3d::Identity());
    right_side_.col(i) = mass * (state.velocities.col(i) + h_ * gravity_);
    if (unknown_[i] >= 0) sizes[i] = right_side_.col(i).norm();
  }
  for (const Spring& s : model_.springs) {
    const Eigen::Vector3d d = state.positions.col(s.j) - state.positions.col(s.i);
    const double length = d.norm();
    const Eigen::Vector3d n = d / length;
    // The damping force of the start and its linearization cancel on the right-hand side.
    const Eigen::Vector3d impulse = h_ * s.stiffness * (length - s.rest_length) * n;
    right_side_.col(s.i) += impulse;
    right_side_.col(s.j) -= impulse;
    if (unknown_[s.i] >= 0) sizes[s.i] += impulse.norm();
    if (unknown_[s.j] >= 0) sizes[s.j] += impulse.norm();

    double across = 1.0 - s.rest_length / length;
    const bool safe = taken[s.i] < model_.masses[s.i] && taken[s.j] < model_.masses[s.j];
    if (!safe) across = std::max(across, 0.0);
    const Eigen::Matrix3d nn = n * n.transpose();
    const Eigen::Matrix3d block =
        h_ * s.damping * nn +
        h_ * h_ * s.stiffness * (nn + across * (Eigen::Matrix3d::Identity() - nn));
    addBlock(s.i, s.i, block);
    addBlock(s.j, s.j, block);
    addBlock(s.i, s.j, -block);
    addBlock(s.j, s.i, -block);
  }
  matrix_.setFromTriplets(triplets_.begin(), triplets_.end());
  b_ = gather(right_side_);
  terms_ = sizes.norm();
}

template <typename Factor>
Eigen::VectorXd PlainEigen::solveDirectly(Factor& factor) {
  if (!analyzed_) factor.analyzePattern(matrix_);
  analyzed_ = true;
  factor.factorize(matrix_);
  return factor.solve(b_);
}

void PlainEigen::solve(State& state) {
  Eigen::VectorXd v;
  if (solver_ == Solver::kConjugateGradient) {
    conjugate_gradient_.compute(matrix_);
    v = conjugate_gradient_.solveWithGuess(b_, gather(state.velocities));
  } else if (solver_ == Solver::kSimplicialLdlt) {
    v = solveDirectly(ldlt_);
  } else {
    v = solveDirectly(cholmod_);
  }
  for (std::uint32_t i = 0; i < model_.particleCount(); ++i) {
    if (unknown_[i] < 0) continue;
    state.velocities.col(i) = v.segment<3>(3 * unknown_[i]);
    state.positions.col(i) += h_ * state.velocities.col(i);
  }
}

double PlainEigen::residual(const Vectors& velocities) const {
  return (b_ - matrix_ * gather(velocities)).norm() / b_.norm();
}

double PlainEigen::rounding() const {
  return std::numeric_limits<double>::epsilon() * terms_ / b_.norm();
}

Eigen::VectorXd PlainEigen::gather(const Vectors& vectors) const {
  Eigen::VectorXd gathered(b_.size());
  for (std::uint32_t i = 0; i < model_.particleCount(); ++i) {
    if (unknown_[i] >= 0) gathered.segment<3>(3 * unknown_[i]) = vectors.col(i);
  }
  return gathered;
}

}  // namespace mass_spring
