#pragma once

#include <cstddef>
#include <vector>

#include "effects/spring_batches.h"
#include "effects/spring_kernels.h"

namespace mass_spring {

/// Springs that act one after the other, each from where the one before it has left its ends. A
/// spring moves them as implicit Euler would if it were alone, so that none overshoots:
///   m_i dx_i = -m_j dx_j = h^2 f n / (1 + (k h^2 + c h) (1/m_i + 1/m_j)),
///   f = k (l - L) + c n . (d - d_before) / h,  d = x_j - x_i = l n.
/// That is one iteration of extended position based dynamics from multipliers that are zero
/// (Macklin et al., "Small steps in physics simulation", 2019; damping as in eq. 26 of Macklin,
/// Mueller and Chentanez, "XPBD", 2016), written so that k = 0 needs no exception.
class SpringRelaxation {
 public:
  /// @param batches  that outlive this
  /// @param masses   kg per particle, > 0
  SpringRelaxation(const SpringBatches& batches, const Eigen::VectorXd& masses);

  /// All springs once, over a step of h [s].
  /// @param pinned     per particle: what does not give way
  /// @param current    rest lengths [m] by Spring::number; empty = as built
  /// @param before     positions at the start of the step
  /// @param positions  where the particles would be without springs; and then where they are
  void relax(double h, const std::vector<char>& pinned, const std::vector<double>& current,
             const Vectors& before, Vectors& positions);

 private:
  /// A run, or a part of it, which has shares by lane.
  struct Pass {
    std::size_t run;
    std::size_t first_share;
  };
  void findShares(double h, const std::vector<char>& pinned);
  double share(double stiffness, double damping, std::uint32_t i, std::uint32_t j) const;
  void relaxGathered(const std::vector<double>& current);

  const SpringBatches& batches_;
  const Eigen::VectorXd& masses_;
  double h_ = 0.0;  // s, that the shares belong to
  std::vector<char> pinned_;
  std::vector<Pass> passes_;
  std::vector<double> shares_;  // of the runs, then of the gathered springs
  std::size_t first_gathered_ = 0;
  Columns inverse_masses_, before_, positions_;
};

}  // namespace mass_spring
