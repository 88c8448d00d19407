#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "mass_spring_sim/model.h"

namespace mass_spring {

/// Springs that one pass of a vectorized loop evaluates, one per lane.
struct SpringBatch {
  static constexpr std::uint32_t kMaxLanes = 512;  ///< arrays of these stay in the first cache
  static constexpr std::uint32_t kLaneWidth = 8;   ///< lanes come in multiples of it

  std::uint32_t lanes = 0;
  std::uint32_t i = 0, j = 0;       ///< ends of the first lane of a run; the next ones follow
  bool uniform = false;             ///< one value serves all lanes
  bool damped = false;              ///< some of the springs are
  std::size_t first_value = 0;      ///< of stiffness, damping and rest length
  std::size_t first_lane = 0;       ///< the number of lanes in the batches before it
  std::uint32_t needed = 0;         ///< particles that this run or one before it reads: [0, needed)
  std::uint32_t finished = 0;       ///< particles that no later run has a spring of: [0, finished)
  std::vector<std::uint32_t> gaps;  ///< lanes of a run that are no springs
  /// Of gathered springs; fewer than lanes, what is left of them has stiffness and damping 0.
  std::vector<std::uint32_t> ends_i, ends_j;
};

/// The springs that have stiffness or damping, sorted for loops over separate coordinate arrays.
/// Most springs of ropes, cloth and lattices lie in runs: lane s joins the particles i + s and
/// j + s, so that ends are contiguous in memory. A run may step over pairs that are no springs (at
/// the ends of a grid's rows) and past the last particle (to a multiple of kLaneWidth); what is
/// computed in these gaps is dropped. What no run takes, as in meshes, is gathered.
class SpringBatches {
 public:
  /// @param apart  each spring has values of its own, as rest lengths change
  explicit SpringBatches(const std::vector<Spring>& springs, bool apart = false);

  /// The rest lengths of one batch, gathered from a state.
  struct RestLengths {
    alignas(64) double values[SpringBatch::kMaxLanes];
  };

  /// Ascending in i, so that particles come in once, for all of their springs.
  const std::vector<SpringBatch>& runs() const { return runs_; }
  const std::vector<SpringBatch>& gathered() const { return gathered_; }
  std::size_t lanes() const { return lanes_; }
  bool elastic() const { return elastic_; }  ///< some spring has stiffness
  bool damped() const { return damped_; }

  /// From first_value on by lane; a single one if the batch is uniform.
  const double* stiffness(const SpringBatch& batch) const {
    return stiffness_.data() + batch.first_value;
  }
  /// @param current  m, by Spring::number; empty = as built
  /// @param room     for those of the batch, if they are to be gathered
  const double* restLength(const SpringBatch& batch, const std::vector<double>& current,
                           RestLengths& room) const {
    if (current.empty() || number_of_value_.empty()) return rest_length_.data() + batch.first_value;
    return gatherRestLengths(batch, current, room);
  }
  /// Only if damped().
  const double* damping(const SpringBatch& batch) const {
    return damping_.data() + batch.first_value;
  }

  /// visit(i, j, lane counted through all batches, stiffness, damping, rest length) of each spring.
  /// @param current  rest lengths, as above
  template <typename Visit>
  void forEach(const std::vector<double>& current, Visit visit) const {
    RestLengths room;
    for (const auto* batches : {&runs_, &gathered_}) {
      for (const SpringBatch& batch : *batches) {
        auto gap = batch.gaps.begin();
        const double* const rest_length = restLength(batch, current, room);
        const bool run = batch.ends_i.empty();
        const std::size_t springs = run ? batch.lanes : batch.ends_i.size();
        for (std::uint32_t s = 0; s < springs; ++s) {
          if (gap != batch.gaps.end() && *gap == s) {
            ++gap;
            continue;
          }
          const std::size_t value = batch.uniform ? 0 : s;
          visit(run ? batch.i + s : batch.ends_i[s], run ? batch.j + s : batch.ends_j[s],
                batch.first_lane + s, stiffness(batch)[value],
                batch.damped ? damping(batch)[value] : 0.0, rest_length[value]);
        }
      }
    }
  }

 private:
  static constexpr std::uint32_t kNoSpring = 0xffffffff;
  struct Candidate;
  static std::vector<Candidate> sortedCandidates(const std::vector<Spring>& springs);
  void findRanges();
  void addRun(const std::vector<Candidate>& springs, bool apart);
  void gather(const std::vector<Candidate>& springs, bool apart);
  void addValues(const Candidate& candidate, bool apart);
  const double* gatherRestLengths(const SpringBatch& batch, const std::vector<double>& current,
                                  RestLengths& room) const;

  std::vector<SpringBatch> runs_, gathered_;
  std::vector<double> stiffness_, damping_, rest_length_;
  std::vector<std::uint32_t> number_of_value_;  // of the spring; only if apart
  std::size_t lanes_ = 0;
  bool elastic_ = false, damped_ = false;
};

}  // namespace mass_spring
