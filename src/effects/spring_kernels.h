#pragma once

#include <Eigen/Core>
#include <algorithm>
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

/// One array per coordinate, or per entry of a block: element i belongs to particle i. Arrays begin
/// with cache lines, as vectors that lie across two of them take twice as long.
class Columns {
 public:
  static constexpr std::uint32_t kBeyond = 2 * SpringBatch::kLaneWidth;

  /// Makes room for particles and kBeyond elements more, all zero.
  void reset(std::size_t particles, std::size_t columns) {
    lines_per_column_ = (particles + kBeyond) / kPerLine + 1;
    lines_.assign(lines_per_column_ * columns, Line());
  }
  double* operator[](std::size_t column) { return lines_[column * lines_per_column_].values; }
  const double* operator[](std::size_t column) const {
    return lines_[column * lines_per_column_].values;
  }

 private:
  static constexpr std::size_t kPerLine = 8;
  struct alignas(64) Line {
    double values[kPerLine] = {};
  };
  std::vector<Line> lines_;
  std::size_t lines_per_column_ = 0;
};

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
  static constexpr std::uint32_t kPadding = SpringBatch::kLaneWidth;

  double* of(int entry) { return padded_[entry] + kPadding; }
  const double* of(int entry) const { return padded_[entry] + kPadding; }
  /// Sets to 0 what belongs to no spring: gaps, and the padding before and after the lanes.
  void clear(const SpringBatch& batch) {
    for (auto& entry : padded_) {
      double* lanes = entry + kPadding;
      for (std::uint32_t gap : batch.gaps) lanes[gap] = 0.0;
      std::fill_n(entry, kPadding, 0.0);
      std::fill_n(lanes + batch.lanes, kPadding, 0.0);
    }
  }

 private:
  alignas(64) double padded_[entries][kPadding + SpringBatch::kMaxLanes + kPadding];
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

/// What springs that act one after the other share.
struct Relaxation {
  double h;                      ///< s
  const double* inverse_masses;  ///< 1/kg per particle, 0 for pinned ones and beyond the last
  const Columns& before;         ///< positions at the start of the step, which damping needs
  Columns& positions;
};
/// Lanes of a run that can be relaxed at once as no two of them have a particle in common. Of runs
/// whose ends are too near for whole vectors that is every second group of |j - i| lanes: they take
/// two passes, each with shares of its own groups only.
struct RelaxedLanes {
  std::uint32_t passes, lanes;
  explicit RelaxedLanes(const SpringBatch& run);
  /// Does lane s have its turn in that pass?
  bool inPass(std::uint32_t pass, std::uint32_t s) const { return (s / group) % passes == pass; }

 private:
  std::uint32_t group;
};
/// Moves the ends of one spring after the other, or of many at once that have no particle in
/// common, as implicit Euler would if there were no others: by h^2 f share / m with its force f.
/// @param shares  per lane, 0 for what is not to be moved
void relaxRun(const SpringBatch& run, const SpringLanes& springs, const double* shares,
              const Relaxation& relaxation);

/// Sum of the lanes, of eight partial sums.
double sumLanes(const double* values, std::uint32_t lanes);
/// What lane s holds is added for particle i + s, and subtracted (forces) or added (others) for
/// particle j + s.
void addLanes(const LaneResults<3>& force, const SpringBatch& run, Columns& columns);
void addLanes(const LaneResults<6>& block, const SpringBatch& run, Columns& columns);
/// The same with a column by itself, which needs Columns::kBeyond elements more than particles.
void addLanes(const LaneResults<1>& values, const SpringBatch& run, double* column);
/// blocks[slots[s]] -= block of lane s
void subtractBlocks(const LaneResults<6>& block, const std::uint32_t* slots, std::uint32_t lanes,
                    SymmetricBlock* blocks);

}  // namespace mass_spring
