#pragma once

#include <functional>

#include "mass_spring_sim/model.h"
#include "mass_spring_sim/scene.h"
#include "tools/modes.h"
#include "tools/reference.h"
#include "tools/study_table.h"

namespace mass_spring {

/// Runs of one setting that is not long: their median counts.
constexpr std::size_t kStudyRuns = 3;

/// What all settings of a study have in common.
struct Study {
  Scene scene;
  double duration = 0.0;    ///< s
  double frame_rate = 0.0;  ///< Hz, at which states are compared
  Reference reference;
  std::size_t compared = 0;  ///< frames, from the first, that the errors are taken from
  Modes modes;               ///< of those frames
  std::function<bool()> interrupted = [] { return false; };
};

/// Runs the scene with a setting, thrice where it is short, and compares it with the reference.
/// @param patience  s for one run; after that it is "unfinished" and its errors are infinite
StudyRow measure(const Study& study, const StudySetting& setting, double patience);

/// The frames that are compared: those before the spread reaches the finest error of interest, or,
/// where that leaves less than a quarter of them, a coarser one.
std::size_t framesToCompare(const Reference& reference);
/// m, diagonal of the room that the particles move through.
double extent(const Reference& reference);

/// kg m/s
Eigen::Vector3d momentum(const Model& model, const State& state);
/// m, mean over the particles along -gravity; along z where there is none
double meanHeight(const Scene& scene, const State& state);

}  // namespace mass_spring
