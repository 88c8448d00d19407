#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "problems.h"
#include "solvers/block_pattern.h"
#include "solvers/step_matrix.h"

namespace mass_spring {

using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// A positive definite matrix on a random graph of n particles, and the same one dense.
struct RandomSystem {
  using Pattern = std::shared_ptr<const BlockPattern>;
  Pattern pattern;
  StepMatrix matrix;
  Eigen::MatrixXd dense;
  Vectors b;

  explicit RandomSystem(const Pairs& pairs, std::uint32_t n, double stiffness = 100.0)
      : pattern(makePattern(pairs, n)), matrix(pattern), dense(3 * n, 3 * n), b(3, n) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    matrix.setMasses(1.0, Eigen::VectorXd::Constant(n, 0.5));
    dense.setZero();
    dense.diagonal().setConstant(0.5);
    for (const auto& [i, j] : pairs) {
      const Eigen::Vector3d d(unit(random), unit(random), unit(random));
      const SymmetricBlock block =
          SymmetricBlock::axial(d.normalized(), stiffness, 0.3 * stiffness);
      matrix.addElement(i, j, pattern->slot(i, j), block);
      const Eigen::Matrix3d s = block.dense();
      dense.block<3, 3>(3 * i, 3 * i) += s;
      dense.block<3, 3>(3 * j, 3 * j) += s;
      dense.block<3, 3>(3 * i, 3 * j) -= s;
      dense.block<3, 3>(3 * j, 3 * i) -= s;
    }
    for (Eigen::Index k = 0; k < b.size(); ++k) b.data()[k] = unit(random);
  }

  static Pattern makePattern(const Pairs& pairs, std::uint32_t n) {
    PatternBuilder builder;
    for (const auto& [i, j] : pairs) builder.couple(j, i);
    return std::make_shared<BlockPattern>(n, std::move(builder));
  }

  Vectors solution() const {
    const Eigen::VectorXd x =
        dense.ldlt().solve(Eigen::Map<const Eigen::VectorXd>(b.data(), b.size()));
    return Eigen::Map<const Vectors>(x.data(), 3, b.cols());
  }
};

/// That of randomNet().
inline Pairs randomGraph(std::uint32_t n) {
  Pairs pairs;
  for (const auto& s : randomNet(static_cast<int>(n), 1.0, 1.0, 4).springs) {
    pairs.emplace_back(s[0], s[1]);
  }
  return pairs;
}

/// Each particle is joined to the `reach` before it.
inline Pairs chain(std::uint32_t n, std::uint32_t reach = 1) {
  Pairs pairs;
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t j = i - std::min(i, reach); j < i; ++j) pairs.emplace_back(i, j);
  }
  return pairs;
}

}  // namespace mass_spring
