#pragma once

#include <Eigen/Core>
#include <vector>

#include "scheme_choice.h"

namespace mass_spring {

/// Upper bounds of what springs and effects of a model can do where they are now, while
/// boundSpectrum() holds wherever they are. A lattice, whose springs at a particle point in all
/// directions, can vibrate at 1 / sqrt(3) of that, and its damping is a third.
///
/// For positive semidefinite S and any q > 0, [S -S; -S S] <= [(1 + q) S, 0; 0, (1 + 1 / q) S]: the
/// whole matrix lies below one that has only 3 x 3 blocks on the diagonal. With q = y_j / y_i, the
/// largest eigenvalue of these is sharp for a chain and for springs along one line, where the power
/// iteration that finds y is that of Collatz's bound.
class LocalSpectrum {
 public:
  explicit LocalSpectrum(const Model& model);
  /// For small motions of the free particles about these positions.
  /// @param rest_lengths  m, by Spring::number; empty = as built
  SpectrumBounds at(const Vectors& positions, const std::vector<double>& rest_lengths,
                    const std::vector<char>& pinned);

 private:
  using Symmetric = Eigen::Array<double, 6, 1>;  // xx yy zz xy xz yz
  void sumBlocks(const Vectors& positions, const std::vector<double>& rest_lengths);
  /// Of the block divided by the mass; 0 if that is sure to lie below `least`.
  double eigenvalue(const std::vector<Symmetric>& blocks, std::size_t particle, double least) const;

  const Model& model_;
  Eigen::VectorXd weights_;  // y, per particle, > 0
  std::vector<Symmetric> stiffness_, damping_;
  Eigen::VectorXd held_,
      braked_;  // per particle, N/m and N s/m: what effects other than springs do
};

}  // namespace mass_spring
