#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "mass_spring_sim/state.h"
#include "solvers/block_pattern.h"
#include "solvers/symmetric_block.h"
#include "thread_pool.h"

namespace mass_spring {

/// What joins a few particles for a while, along one direction: adds stiffness g g^T to a matrix,
/// where particle a has the share weights[a] normal of g.
struct Tie {
  std::array<std::uint32_t, 4> particles;
  Eigen::Vector4d weights;
  Eigen::Vector3d normal;
  double stiffness;  ///< weighted like the matrix, >= 0
};

/// The symmetric matrix that implicit schemes solve with, alpha_a M + alpha_v D + alpha_x K, as 3x3
/// blocks on a fixed pattern. Ties lie over it: they come and go without a new analysis of the
/// pattern, products count them, and factors and preconditioners, which see the blocks, leave them
/// to the iterations.
class StepMatrix {
 public:
  /// @param threads  to share the work of solving; nullptr = the caller's alone
  explicit StepMatrix(std::shared_ptr<const BlockPattern> pattern, ThreadPool* threads = nullptr);

  const BlockPattern& pattern() const { return *pattern_; }
  const std::vector<SymmetricBlock>& diagonal() const { return diagonal_; }
  const std::vector<SymmetricBlock>& upper() const { return upper_; }

  /// For effects that add many elements at once.
  std::vector<SymmetricBlock>& diagonal() { return diagonal_; }
  std::vector<SymmetricBlock>& upper() { return upper_; }

  /// Forgets everything and puts weight * mass on the diagonal.
  void setMasses(double weight, const Eigen::VectorXd& masses);
  /// Adds the element matrix [B -B; -B B] of a pair of particles.
  void addElement(std::uint32_t i, std::uint32_t j, std::size_t slot, const SymmetricBlock& block) {
    diagonal_[i] += block;
    diagonal_[j] += block;
    upper_[slot] -= block;
  }
  void addTie(const Tie& tie) { ties_.push_back(tie); }
  const std::vector<Tie>& ties() const { return ties_; }
  /// What setMasses() put on the diagonal of a particle.
  double mass(std::uint32_t i) const { return weighted_masses_[i]; }

  /// work(part, begin, end) for the halves of the rows, at the same time if there are threads.
  template <typename Work>
  void inHalves(const Work& work) const {
    const RowHalves& halves = pattern_->halves();
    const auto on_part = [&](std::uint32_t part) {
      work(part, halves.begin(part), halves.end(part));
    };
    if (threads_ != nullptr) {
      threads_->run(halves.parts(), on_part);
    } else {
      for (std::uint32_t part = 0; part < halves.parts(); ++part) on_part(part);
    }
  }
  /// y = A x
  void multiply(const Vectors& x, Vectors& y) const;
  /// y += scale times what ties make of x. Floats have a fourth row, which stays as it is.
  template <typename V>
  void addTies(double scale, const V& x, V& y) const;
  /// Adds a share of the largest diagonal entry to the whole diagonal.
  void shift(double share);
  /// Drops the blocks between pinned particles and all others: what is left solves for the free.
  void decouple(const std::vector<char>& pinned);

 private:
  void multiplyRows(std::uint32_t begin, std::uint32_t end, const double* x, double* y) const;
  void addCoupling(const double* x, double* y) const;

  std::shared_ptr<const BlockPattern> pattern_;
  ThreadPool* threads_;
  std::vector<SymmetricBlock> diagonal_;
  std::vector<SymmetricBlock> upper_;
  std::vector<Tie> ties_;
  Eigen::VectorXd weighted_masses_;
};

template <typename V>
void StepMatrix::addTies(double scale, const V& x, V& y) const {
  for (const Tie& tie : ties_) {
    double sum = 0.0;
    for (int a = 0; a < 4; ++a) {
      const std::uint32_t i = tie.particles[static_cast<std::size_t>(a)];
      sum += tie.weights[a] * tie.normal.dot(x.col(i).template head<3>().template cast<double>());
    }
    const Eigen::Vector3d along = scale * tie.stiffness * sum * tie.normal;
    for (int a = 0; a < 4; ++a) {
      const std::uint32_t i = tie.particles[static_cast<std::size_t>(a)];
      y.col(i).template head<3>() += (tie.weights[a] * along).cast<typename V::Scalar>();
    }
  }
}

}  // namespace mass_spring
