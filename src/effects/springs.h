#pragma once

#include <vector>

#include "effects/effect.h"
#include "effects/spring_batches.h"
#include "effects/spring_kernels.h"
#include "mass_spring_sim/model.h"
#include "solvers/symmetric_block.h"

namespace mass_spring {

/// Stiffness block S = d^2E/dd^2 of one spring (course notes eq. 17, with K = -df/dx); the spring
/// adds [S -S; -S S] to K.
///   S = k n n^T + k r (I - n n^T),  r = 1 - L/l,  d = x_j - x_i = l n
/// Its eigenvalues are k along the spring and k r across it, negative in compression. With r
/// replaced by max(r, 0) it is the nearest positive semidefinite matrix.
SymmetricBlock springStiffness(const Eigen::Vector3d& d, double stiffness, double rest_length,
                               bool project);

/// Springs and the damping along them, in one pass as they share their direction n:
/// E = k/2 (l - L)^2 (course notes eq. 5), f_i = k (l - L) n (eq. 1) + k_d (v_ij . n) n (eq. 2).
/// With D = -df/dv, the derivative that eq. 18 leaves to the reader is [B -B; -B B] with
/// B = k_d n n^T, positive semidefinite. The damping's dependence on the positions stays out of the
/// matrix (the notes). Without damping there is no memory and no arithmetic for it.
/// Its methods share scratch memory: not for two threads at once.
class Springs : public Effect {
 public:
  /// @param springs    at least one with stiffness or damping
  /// @param particles  that they join, counted through the model
  Springs(const std::vector<Spring>& springs, std::uint32_t particles);

  std::vector<std::string> names() const override;
  const SpringBatches& batches() const { return batches_; }
  /// Makes room for rest lengths that change.
  /// @param springs  that the effect was made of
  void keepApart(const std::vector<Spring>& springs);
  /// @param rest_lengths  m, from now on; empty = those of the springs
  void setRestLengths(const std::vector<Spring>& springs, const std::vector<double>& rest_lengths);

  void addEnergy(const Vectors& positions, Energy& energy) const override;
  void addForces(const Vectors& positions, const Vectors& velocities,
                 Vectors& forces) const override;
  void addForces(const Vectors& positions, const Vectors& velocities, Vectors& forces,
                 Energy& energy, double& dissipation) const override;
  void addForcesHolding(const Vectors& held, const Vectors& positions, const Vectors& velocities,
                        Vectors& forces, Energy& energy, double& dissipation) const override;
  bool dampingTurns() const override { return batches_.damped(); }
  void addForceDerivative(const Vectors& x, const Vectors& v, const Vectors& dx, const Vectors& dv,
                          Vectors& df) const override;
  void addPattern(PatternBuilder& pattern) const override;
  void findSlots(const BlockPattern& pattern) override;
  std::uint32_t addDerivatives(const Vectors& positions, const Vectors& velocities,
                               const MatrixWeights& weights, Projection projection,
                               StepMatrix& matrix) const override;
  std::uint32_t linearize(const Vectors& positions, const Vectors& velocities, double w,
                          StepMatrix& matrix, Vectors& forces) const override;

 private:
  /// visit(batch, lanes) of all batches, runs first; and finish(from, to) as soon as the runs are
  /// done with these particles. Without velocities, nothing is damped.
  template <typename Visit, typename Finish>
  void forEachBatch(const Vectors& positions, const Vectors* velocities, Visit visit,
                    Finish finish) const;
  /// Without velocities, nothing is damped.
  void addForces(const Vectors& positions, const Vectors* velocities, Vectors& forces) const;
  void addForces(const Vectors& positions, const Vectors* velocities, Vectors& forces,
                 Energy& energy, double& dissipation) const;
  void addTo(Vectors& forces, const SpringBatch& batch, LaneResults<3>& force) const;
  void findFloors(const Vectors& positions, const MatrixWeights& weights, Projection projection,
                  const StepMatrix& matrix) const;

  SpringBatches batches_;
  std::vector<std::uint32_t> slots_;  // of blocks, by lane; those of gaps get zeros
  mutable Columns positions_, velocities_;
  mutable Columns forces_, diagonal_;  // zero between calls
  mutable Eigen::VectorXd taken_;      // and then the floors
};

}  // namespace mass_spring
