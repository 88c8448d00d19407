#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "effects/effect.h"
#include "effects/spring_batches.h"
#include "mass_spring_sim/state.h"
#include "solvers/symmetric_block.h"

// Loops over many springs or particles at once that compilers turn into vector instructions. They
// do the operations of the plain formulas in the same order with all compilations (dispatch.h), and
// so give the same bits whatever the width of vectors.
namespace mass_spring {

/// One array per coordinate, or per entry of a block (the columns): row i belongs to particle i.
using Columns = Eigen::MatrixXd;

/// The coordinates of particles [from, to) to the first three columns.
void separate(const Vectors& vectors, std::uint32_t from, std::uint32_t to, Columns& columns);
/// vectors += columns for particles [from, to); the columns become zero.
void moveInto(Vectors& vectors, std::uint32_t from, std::uint32_t to, Columns& columns);
/// The same with six columns and blocks: xx, xy, xz, yy, yz, zz.
void moveInto(std::vector<SymmetricBlock>& blocks, std::uint32_t from, std::uint32_t to,
              Columns& columns);

/// Where the coordinates of the springs' ends begin, lane after lane.
struct EndColumns {
  const double *x = nullptr, *y = nullptr, *z = nullptr;
};

/// What one pass reads.
struct SpringLanes {
  std::uint32_t lanes;
  bool uniform, damped;
  const double *stiffness, *damping, *rest_length;
  EndColumns xi, xj;  ///< positions
  EndColumns vi, vj;  ///< velocities, only if damped
};

/// What one pass computes per lane, in one array per coordinate or entry.
template <int entries>
struct LaneResults {
  alignas(64) double of[entries][SpringBatch::kMaxLanes];

  void clear(const std::vector<std::uint32_t>& gaps) {
    for (std::uint32_t lane : gaps) {
      for (auto& entry : of) entry[lane] = 0.0;
    }
  }
};

/// Force on i (x, y, z).
void springForces(const SpringLanes& springs, LaneResults<3>& force);
/// Force on i, and energy k/2 (l - L)^2 and half the power lost, c/2 (w . n)^2.
void springForcesAndEnergies(const SpringLanes& springs, LaneResults<3>& force,
                             LaneResults<2>& energies);

/// How much a compressed spring could take from the smallest eigenvalue of the diagonal block of
/// each of its ends, at most 2 k |r|, as [1 -1; -1 1] <= 2 I.
void springIndefiniteness(const SpringLanes& springs, double weight, LaneResults<1>& taken);
/// The weighted block that the spring adds as [B -B; -B B], with r = max(1 - L/l, floor), where the
/// floor is the larger one of the two ends; and 1 if that changed r, else 0.
void springBlocks(const SpringLanes& springs, const double* floor_i, const double* floor_j,
                  const MatrixWeights& weights, LaneResults<6>& block, LaneResults<1>& projected);

/// Sum of the lanes, of eight partial sums.
double sumLanes(const double* values, std::uint32_t lanes);
/// to_i[s] += values[s], to_j[s] += values[s]
void addLanes(const LaneResults<1>& values, std::uint32_t lanes, double* to_i, double* to_j);
/// What lane s holds is added for particle i + s, and subtracted (forces) or added (blocks) for
/// particle j + s.
void addLanes(const LaneResults<3>& force, const SpringBatch& run, Columns& columns);
void addLanes(const LaneResults<6>& block, const SpringBatch& run, Columns& columns);
/// blocks[slots[s]] -= block of lane s
void subtractBlocks(const LaneResults<6>& block, const std::uint32_t* slots, std::uint32_t lanes,
                    SymmetricBlock* blocks);

}  // namespace mass_spring
