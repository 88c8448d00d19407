#include "local_spectrum.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "effects/effect.h"

namespace mass_spring {

LocalSpectrum::LocalSpectrum(const Model& model)
    : model_(model),
      stiffness_(model.particleCount()),
      damping_(model.particleCount()),
      held_(Eigen::VectorXd::Zero(model.masses.size())),
      braked_(held_) {
  for (const auto& effect : model.effects) effect->addBounds(held_, braked_);
  Eigen::VectorXd tried = Eigen::VectorXd::Ones(model.masses.size()), next = tried;
  Eigen::VectorXd best = tried;
  double bound = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < kPowerIterations; ++iteration) {
    weights_ = tried;
    sumBlocks(model.start.positions, {});
    for (std::size_t i = 0; i < stiffness_.size(); ++i) {
      next[static_cast<Eigen::Index>(i)] = eigenvalue(stiffness_, i, 0.0);
    }
    if (next.maxCoeff() < bound) {
      bound = next.maxCoeff();
      best = tried;
    }
    next.array() *= tried.array();
    const double largest = next.maxCoeff();
    if (!(largest > 0.0)) break;
    // Every positive y gives a bound: parts of the scene that are much slower stay in it.
    tried = (next / largest).cwiseMax(1e-12);
  }
  weights_ = best;
}

SpectrumBounds LocalSpectrum::at(const Vectors& positions, const std::vector<double>& rest_lengths,
                                 const std::vector<char>& pinned) {
  sumBlocks(positions, rest_lengths);
  double stiffest = 0.0, most_damped = 0.0;
  for (std::size_t i = 0; i < stiffness_.size(); ++i) {
    if (pinned[i]) continue;
    stiffest = std::max(stiffest, eigenvalue(stiffness_, i, stiffest));
    most_damped = std::max(most_damped, eigenvalue(damping_, i, most_damped));
  }
  return {std::sqrt(stiffest), most_damped};
}

void LocalSpectrum::sumBlocks(const Vectors& positions, const std::vector<double>& rest_lengths) {
  Symmetric identity;
  identity << 1.0, 1.0, 1.0, 0.0, 0.0, 0.0;
  for (std::size_t i = 0; i < stiffness_.size(); ++i) {
    stiffness_[i] = held_[static_cast<Eigen::Index>(i)] * identity;
    damping_[i] = braked_[static_cast<Eigen::Index>(i)] * identity;
  }
  for (const Spring& s : model_.springs) {
    const Eigen::Vector3d d = positions.col(s.j) - positions.col(s.i);
    const double square = d.squaredNorm(), length = std::sqrt(square);
    Symmetric along = identity;  // a spring without length has no direction
    if (square > 0.0) {
      along << d.x() * d.x(), d.y() * d.y(), d.z() * d.z(), d.x() * d.y(), d.x() * d.z(),
          d.y() * d.z();
      along /= square;
    }
    // Across the spring there is only what tension gives.
    const double rest = rest_lengths.empty() ? s.rest_length : rest_lengths[s.number];
    const double across = length > rest ? 1.0 - rest / length : 0.0;
    const double at_i = 1.0 + weights_[s.j] / weights_[s.i];
    const double at_j = 1.0 + weights_[s.i] / weights_[s.j];
    const Symmetric block = s.stiffness * ((1.0 - across) * along + across * identity);
    stiffness_[s.i] += at_i * block;
    stiffness_[s.j] += at_j * block;
    damping_[s.i] += at_i * s.damping * along;
    damping_[s.j] += at_j * s.damping * along;
  }
}

double LocalSpectrum::eigenvalue(const std::vector<Symmetric>& blocks, std::size_t particle,
                                 double least) const {
  const double mass = model_.masses[static_cast<Eigen::Index>(particle)];
  const Symmetric& a = blocks[particle];
  const double trace = a.head<3>().sum();
  if (trace <= least * mass) return 0.0;
  Eigen::Matrix3d matrix;
  matrix << a[0], a[3], a[4], a[3], a[1], a[5], a[4], a[5], a[2];
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(matrix, Eigen::EigenvaluesOnly);
  return solver.eigenvalues()[2] / mass;
}

}  // namespace mass_spring
