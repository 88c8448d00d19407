#pragma once

#include <string>
#include <vector>

#include "rival.h"
#include "tools/study_run.h"

namespace mass_spring {

/// One setting of anyone's on a scene, measured as accuracy_study does.
struct RivalRow {
  std::string scene, contender, setting;
  bool ours = false;
  double rms_error = 0.0;  ///< m, over the free particles and the frames that can be compared
  double max_error = 0.0;  ///< m, likewise
  double seconds = 0.0;    ///< of wall time per simulated second; the median of repetitions
  std::string status;      ///< as in accuracy_study; "converged" for rivals that report nothing

  bool usable() const { return status == "converged" || status == "degraded"; }
};

struct RivalRunOptions {
  double time_limit = 10.0;  ///< s, for each series on each scene, repetitions included
  double finest = 1e-5;      ///< m; a series that is far below it is not refined
};

/// All settings of all series, and all schemes of the library, with the rows of those that the time
/// limit leaves out as "unfinished". Prints each row as it comes.
/// @param name  of the scene
std::vector<RivalRow> measureAll(const Study& study, const std::string& name,
                                 const std::vector<RivalSeries>& rivals,
                                 const RivalRunOptions& options);

std::string rivalHeader();
std::string toCsv(const RivalRow& row);

/// Markdown: for each error of interest the cheapest of ours, the cheapest rival and their ratio.
/// @param rows         of one scene
/// @param finest_shown  m, below which errors mean nothing
std::string rivalTable(const std::vector<RivalRow>& rows, double finest_shown);

}  // namespace mass_spring
