#pragma once

#include "solvers/galerkin.h"
#include "solvers/row_halves.h"

namespace mass_spring {

/// Symmetric block Gauss-Seidel on one level of a multigrid, and products. A large level is swept
/// in two halves at once: each half uses its own newest values and the other's from before, whoever
/// sweeps it, so that the result does not depend on the number of threads.
///
/// Vectors hold four floats per particle, of which the fourth means nothing.
class BlockSweep {
 public:
  explicit BlockSweep(const BlockRows& rows);

  const RowHalves& halves() const { return halves_; }

  /// Inverts the diagonal blocks of a part. One that is not positive definite is replaced by a
  /// multiple of the unit matrix, so that the sweeps stay finite; one of zeros by zero.
  void prepare(const LevelMatrix& matrix, std::uint32_t part);
  /// From z = 0: z becomes (D + U)^-1 b within the part, from its last particle to its first, and
  /// r what this leaves of b there.
  void sweepDown(const LevelMatrix& matrix, std::uint32_t part, const float* b, float* z, float* r);
  /// z becomes (D + L)^-1 (r - U z) within the part; r is used up.
  void sweepUp(const LevelMatrix& matrix, std::uint32_t part, float* r, float* z);
  /// r -= C z for the blocks C between the two parts.
  void couple(const LevelMatrix& matrix, const float* z, float* r) const;

  /// q = A p within the part: row sums times p and blocks times differences of p, so that what is
  /// stiff does not drown what is soft in its rounding.
  void multiply(const LevelMatrix& matrix, std::uint32_t part, const float* p, float* q) const;
  /// The same for the blocks between the two parts, added.
  void multiplyCoupled(const LevelMatrix& matrix, const float* p, float* q) const;

 private:
  RowHalves halves_;
  std::vector<float> inverse_;  // of the diagonal blocks, six each
};

}  // namespace mass_spring
