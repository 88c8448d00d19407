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
class Springs : public Effect {
 public:
  /// @param springs    at least one with stiffness or damping
  /// @param particles  that they join, counted through the model
  /// @param yielding   their rest lengths change
  Springs(const std::vector<Spring>& springs, std::uint32_t particles, bool yielding = false);

  const SpringBatches& batches() const { return batches_; }

  std::unique_ptr<Scratch> makeScratch(ThreadPool& threads) const override;
  void add(const Point& point, Scratch* scratch, const Sums& sums) const override;
  void addForceDerivative(const Point& point, Scratch* scratch, const Vectors& dx,
                          const Vectors& dv, Vectors& df) const override;
  void addPattern(PatternBuilder& pattern) const override;
  void findSlots(const BlockPattern& pattern) override;
  std::uint32_t addDerivatives(const Point& point, Scratch* scratch, const MatrixWeights& weights,
                               Projection projection, StepMatrix& matrix) const override;
  std::uint32_t linearize(const Point& point, Scratch* scratch, double w, StepMatrix& matrix,
                          Vectors& forces) const override;

 private:
  struct Room;
  /// visit(batch, lanes) of all batches, runs first; and finish(from, to) as soon as the runs are
  /// done with these particles.
  template <typename Visit, typename Finish>
  void forEachBatch(const Point& point, bool damped, Room& room, Visit visit, Finish finish) const;
  /// Force on i of each lane, added to the particles at both ends.
  static void addTo(Vectors& forces, const SpringBatch& batch, LaneResults<3>& force, Room& room);
  void addForces(const Point& point, bool damped, Room& room, Vectors& forces) const;
  void addForcesAndEnergies(const Point& point, bool damped, Room& room, Vectors* forces,
                            double& elastic, double& dissipation) const;
  /// Damping as it is at other positions.
  void addDamping(const Vectors& held, const Vectors& velocities, Vectors& forces,
                  double& dissipation) const;
  void findFloors(const Point& point, const MatrixWeights& weights, Projection projection,
                  const StepMatrix& matrix, Room& room) const;

  SpringBatches batches_;
  std::uint32_t particles_;
  std::vector<std::uint32_t> slots_;  // of blocks, by lane; those of gaps get zeros
};

}  // namespace mass_spring
