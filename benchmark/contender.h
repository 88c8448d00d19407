#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "mass_spring_sim/state.h"

namespace mass_spring {

struct StepOutcome {
  std::uint32_t iterations;  ///< of the linear solver, 0 if it is direct
  bool comparable;           ///< it solved the equations that all others solve
};

/// One way to do a step, with what was measured of it.
struct Contender {
  std::string name;
  /// Advances the state. @throws std::exception if it cannot
  std::function<StepOutcome(State&)> step;
  /// What has to be known before a step, and is not part of it.
  std::function<void(const State&)> prepare;

  struct Sample {
    int frame;
    double wall, processor;  ///< ms; the processor's is that of the calling thread
  };
  std::vector<Sample> samples;
  int steps = 0;                ///< comparable or not
  double iterations = 0.0;      ///< summed over the samples
  double worst_residual = 0.0;  ///< |b - A v| / |b|
  std::size_t bytes = 0;        ///< by which the first step made the heap grow
};

/// Steps a copy of `start` and takes down the times, if they are comparable.
/// @return the state reached
State clockStep(Contender& contender, const State& start, int frame, bool& comparable);

/// Whether a contender that may spend `seconds` on all frames has time for this one. The frames
/// that a slow one takes part in are spread evenly.
bool hasTime(const Contender& contender, double seconds, int frame, int frames);

/// Bytes allocated now, by all threads.
std::size_t heapBytes();

/// The value below which `share` of the values lie, share in [0, 1]; NaN if there are none.
double quantile(std::vector<double> values, double share);
double medianWall(const Contender& contender);
/// Median, over the frames that both took part in, of how many times longer `slow` took.
double medianRatio(const Contender& slow, const Contender& fast);

}  // namespace mass_spring
