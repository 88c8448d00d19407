#pragma once

#include "mass_spring_sim/scheme.h"
#include "scene/tree_reader.h"

namespace mass_spring {

/// Reads solver.calibration: a file of accuracy_study with points for the scheme of the options.
/// @param directory  what a relative path is relative to
void readCalibration(const Place& place, const std::string& directory, SolverOptions& solver);

}  // namespace mass_spring
