#pragma once

#include <Eigen/CholmodSupport>
#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <vector>

#include "mass_spring_sim/model.h"

namespace mass_spring {

/// One linearly implicit step (course notes eq. 19) as one writes it with Eigen alone: a list of
/// triplets, setFromTriplets, a solver of Eigen's or, by its wrapper, CHOLMOD. Same forces, same
/// projection of compressed springs and same unknowns as the library: the velocities of the
/// particles that no pin holds.
class PlainEigen {
 public:
  enum class Solver { kConjugateGradient, kSimplicialLdlt, kCholmod };

  /// @param gravity  m/s^2
  /// @param pinned   per particle; pinned particles stand still
  /// @param h        s
  PlainEigen(const Model& model, const Eigen::Vector3d& gravity, const std::vector<char>& pinned,
             double h, Solver solver, double tolerance);

  /// Forces, matrix and right-hand side for a state.
  void assemble(const State& state);

  /// Solves what was assembled, from the velocities of the state, and moves the state on.
  void solve(State& state);

  /// |b - A v| / |b| of what was assembled, for the velocities that another solver found.
  double residual(const Vectors& velocities) const;

  /// By how much the rounding of b's terms may change that residual: near rest, b is the small
  /// difference of large forces.
  double rounding() const;

  int iterations() const {
    const bool iterative = solver_ == Solver::kConjugateGradient;
    return iterative ? static_cast<int>(conjugate_gradient_.iterations()) : 0;
  }
  const Eigen::SparseMatrix<double>& matrix() const { return matrix_; }

 private:
  using Matrix = Eigen::SparseMatrix<double>;
  void addBlock(std::uint32_t i, std::uint32_t j, const Eigen::Matrix3d& block);
  Eigen::VectorXd gather(const Vectors& vectors) const;
  /// The pattern is analyzed once.
  template <typename Factor>
  Eigen::VectorXd solveDirectly(Factor& factor);

  const Model& model_;
  Eigen::Vector3d gravity_;
  double h_;
  Solver solver_;
  std::vector<int> unknown_;  // per particle, its place among the free ones; -1 = pinned
  Vectors right_side_;
  Eigen::VectorXd b_;
  double terms_ = 0.0;  // norm of the sums of the sizes of b's terms
  std::vector<Eigen::Triplet<double>> triplets_;
  Matrix matrix_;
  Eigen::ConjugateGradient<Matrix, Eigen::Lower | Eigen::Upper> conjugate_gradient_;
  Eigen::SimplicialLDLT<Matrix> ldlt_;
  Eigen::CholmodDecomposition<Matrix> cholmod_;  // simplicial or supernodal, as CHOLMOD decides
  bool analyzed_ = false;
};

}  // namespace mass_spring
