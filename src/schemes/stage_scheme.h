#pragma once

#include <array>
#include <optional>

#include "schemes/error_filter.h"
#include "schemes/newton.h"

namespace mass_spring {

/// A Runge-Kutta method whose implicit stages share one diagonal coefficient beta:
///   x_i = x_n + h sum_j<i a_ij v_j + h beta v_i,  and the same for v_i with accelerations.
struct StageTable {
  int stages;
  bool explicit_first;                         ///< stage 0 is the state itself
  double beta;                                 ///< a_ii of the others
  std::array<std::array<double, 2>, 3> below;  ///< a_ij, j < i
  bool ends_with_last;                         ///< the last stage is the result (stiffly accurate)
  std::array<double, 3> error;                 ///< b^ - b of the embedded formula; 0 = none

  /// Where stage i lies in the step: the sum of its row.
  double at(int i) const {
    const auto& row = below[static_cast<std::size_t>(i)];
    return row[0] + row[1] + (i == 0 && explicit_first ? 0.0 : beta);
  }
};

/// The schemes that solve implicit stages: implicit_euler, implicit_midpoint and tr_bdf2 as tables,
/// and bdf2, whose one stage starts from two states instead of one. All go through one Newton loop.
/// Pinned particles take part with their prescribed motion in every stage.
class StageScheme {
 public:
  /// For options.scheme and, as every scheme may end there, for kImplicitEuler.
  StageScheme(Workspace& workspace, const SolverOptions& options, StepSystem& system);

  /// Advances positions and velocities by h [s].
  /// @param scheme  kImplicitEuler, kImplicitMidpoint, kBdf2 or kTrBdf2
  SubstepReport advance(Scheme scheme, double h, const Drive& drive, State& state);

  /// bdf2 remembers the state before its last sub-step. Each attempt at a step starts with what
  /// keep() kept after the last accepted one; after forget(), or where the step grows by more than
  /// bdf2 can bear, a sub-step of tr_bdf2 starts anew.
  void restore();
  void keep();
  void forget() { kept_.step = 0.0; }

 private:
  void advanceStages(const StageTable& table, bool below_rest, double h, const Drive& drive,
                     State& state, SubstepReport& report);
  void advanceTwoStep(double h, const Drive& drive, State& state, SubstepReport& report);
  void estimateError(const StageTable& table, double h, const Drive& drive, const State& end,
                     SubstepReport& report);

  struct Before {
    double step = 0.0;  // s, from there to the state; 0 = there is none
    Vectors positions, velocities;
  };

  Workspace& workspace_;
  Newton newton_;
  std::optional<ErrorFilter> filter_;  // for tr_bdf2
  Vectors base_positions_, base_velocities_, v_;
  std::array<Vectors, 3> stage_velocities_, stage_accelerations_;
  Vectors error_positions_, error_velocities_;
  Before before_, kept_;
};

}  // namespace mass_spring
