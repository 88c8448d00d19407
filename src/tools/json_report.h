#pragma once

#include <nlohmann/json.hpp>

#include "tools/run_statistics.h"

namespace mass_spring {

/// The report of a run; times in s, energies in J.
nlohmann::json jsonReport(const Simulation& simulation, const RunStatistics& statistics);

}  // namespace mass_spring
