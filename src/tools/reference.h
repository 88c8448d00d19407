#pragma once

#include <functional>
#include <vector>

#include "mass_spring_sim/scene.h"
#include "mass_spring_sim/state.h"

namespace mass_spring {

constexpr std::size_t kStarts = 4;

/// Where the particles of a scene truly are, and how far that can be known.
struct Reference {
  double rate = 0.0;           ///< Hz, of its steps
  int substeps = 0;            ///< of rk4 in each
  bool exact = false;          ///< a closed form; else the finest rk4
  std::vector<State> frames;   ///< after each frame
  std::vector<double> doubt;   ///< m, per frame: to rk4 with half as many sub-steps, or at all
  std::vector<double> spread;  ///< m, per frame: to a run whose start is 1e-9 m apart
  /// At the end, of that run; and, where 1 mm cannot be predicted so long, of up to kStarts such
  /// runs, each moved in other directions.
  std::vector<State> ends;
  std::vector<char> pinned;  ///< per particle, at the start

  /// m, root mean square over the particles that no pin of the scene holds.
  double distance(const Vectors& a, const Vectors& b) const;
  /// Frames before the spread has first grown to an error [m]: its horizon of predictability.
  std::size_t horizon(double error) const;
  /// m, the largest doubt in the first frames
  double largestDoubt(std::size_t frames) const;
};

struct ReferenceOptions {
  double duration = 0.0;        ///< s, > 0
  double frame_rate = 0.0;      ///< Hz; the scene's rate is a multiple of it
  double finest = 1e-5;         ///< m, smallest error of interest: before it spreads so far, ...
  double doubt = 1e-7;          ///< m, ... the doubt shall be no larger
  double seconds = 1e9;         ///< wall time after which no finer run is begun
  double starts_seconds = 1e9;  ///< wall time for further starts
  std::function<bool()> interrupted = [] { return false; };
};

/// By a closed form where there is one; else by rk4 in sub-steps below its limit of stability,
/// halved until the doubt is small enough or the time is over.
/// @throws std::runtime_error  rk4 failed, or was interrupted
Reference findReference(const Scene& scene, const ReferenceOptions& options);

/// The scene particle by particle, each at the start moved by `apart` [m] in a direction of its
/// own, another one for each start, [0, kStarts).
Scene movedApart(const Scene& scene, double apart, std::size_t start);

}  // namespace mass_spring
