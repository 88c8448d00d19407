#pragma once

#include <memory>

#include "solvers/preconditioner.h"

namespace mass_spring {

struct LinearResult {
  bool converged = false;
  std::uint32_t iterations = 0;
  double residual = 0.0;    ///< |b - A x| / |b|; 0 where b = 0
  bool indefinite = false;  ///< stopped by a direction along which the matrix is not positive
};

/// Preconditioned conjugate gradients. Solution and residual are in double, directions in float as
/// long as that serves: the residual, which is carried on from iteration to iteration, is computed
/// anew from the solution where it has fallen by some digits and before it is believed to meet the
/// tolerance (van der Vorst and Ye, "Residual replacement strategies for Krylov subspace iterative
/// methods", SIAM J. Sci. Comput. 22, 2000). Where it was wrong, directions are in double.
class ConjugateGradient {
 public:
  ConjugateGradient(std::unique_ptr<Preconditioner> preconditioner, std::uint32_t size);

  /// Takes the matrix for the solutions to come; the first that iterates prepares the
  /// preconditioner.
  void prepare(const StepMatrix& matrix);
  /// Solves A x = b to |b - A x| <= tolerance |b|, starting from the multiple of the x given that
  /// is nearest to the solution (in the norm of A). On failure x is the best iterate so far.
  LinearResult solve(const Vectors& b, double tolerance, std::uint32_t max_iterations, Vectors& x);

 private:
  /// The sum of what work(first, end) returns for the halves of the matrix's rows.
  template <typename Work>
  double sumOverHalves(const Work& work) const;
  /// r = b - A x. @return |r|
  double findResidual(const Vectors& b, const Vectors& x);
  /// q = A p / c. @return c
  double multiply(const FloatVectors& p, FloatVectors& q) const;
  double multiply(const Vectors& p, Vectors& q) const;
  /// How far a solution is.
  struct Progress {
    double unit;        ///< the norm of the residual at the start
    double norm;        ///< of the residual
    double rho_before;  ///< of the last iteration; 0 = the next one is the first
    bool indefinite = false;
  };
  /// One iteration along the directions p. @return whether there was one
  template <typename V>
  bool iterate(V& p, V& q, Vectors& x, Progress& progress);

  std::unique_ptr<Preconditioner> preconditioner_;
  const StepMatrix* matrix_ = nullptr;
  bool prepared_ = false;   // the preconditioner, for matrix_
  bool in_floats_ = false;  // the directions
  Vectors r_;
  FloatVectors scaled_r_, z_, p_, q_;
  Vectors exact_p_, exact_q_;
};

}  // namespace mass_spring
