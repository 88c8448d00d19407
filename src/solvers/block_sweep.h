#pragma once

#include "solvers/galerkin.h"

namespace mass_spring {

/// Symmetric block Gauss-Seidel on one level of a multigrid. A large level is swept in two halves
/// at once: each half uses its own newest values and the other's from before, whoever sweeps it, so
/// that the result does not depend on the number of threads.
///
/// Vectors hold four floats per particle, of which the fourth means nothing.
class BlockSweep {
 public:
  explicit BlockSweep(const BlockRows& rows);

  std::uint32_t parts() const { return parts_; }
  std::uint32_t begin(std::uint32_t part) const { return part == 0 ? 0 : split_; }
  std::uint32_t end(std::uint32_t part) const { return part + 1 == parts_ ? size_ : split_; }

  /// Inverts the diagonal blocks. One that is not positive definite is replaced by a multiple of
  /// the unit matrix, so that the sweeps stay finite; one of zeros by zero.
  void prepare(const LevelMatrix& matrix);
  /// From z = 0: z becomes (D + U)^-1 b within the part, from its last particle to its first, and
  /// r what this leaves of b there.
  void sweepDown(const LevelMatrix& matrix, std::uint32_t part, const float* b, float* z, float* r);
  /// z becomes (D + L)^-1 (r - U z) within the part; r is used up.
  /// @return sum over the part of b . z
  double sweepUp(const LevelMatrix& matrix, std::uint32_t part, const float* b, float* r, float* z);
  /// r -= C z for the blocks C between the two parts.
  void couple(const LevelMatrix& matrix, const float* z, float* r) const;

 private:
  std::uint32_t size_, parts_, split_;
  std::uint32_t first_coupled_;         // the first row with a block between the parts
  std::vector<std::uint32_t> row_end_;  // of the part's own blocks: those of the other part follow
  std::vector<float> inverse_;          // of the diagonal blocks, six each
};

}  // namespace mass_spring
