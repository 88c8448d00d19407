#pragma once

#include <string>
#include <vector>

#include "mass_spring_sim/scheme.h"

namespace mass_spring {

/// The arguments of `accuracy_study`.
struct StudyOptions {
  std::string scene;                     ///< a file
  std::vector<std::string> assignments;  ///< PATH=VALUE, in order of effect
  double duration = 0.0;                 ///< s, > 0
  std::vector<Scheme> schemes;           ///< none twice; empty = all, and auto for accuracies
  std::vector<double> rates;             ///< Hz, ascending; empty = from 30 Hz on, doubled
  std::vector<double> tolerances;        ///< of Newton's iteration, (0, 1), descending
  std::vector<double> accuracies;        ///< m, > 0, for solver.accuracy
  double time_limit = 300.0;             ///< s of wall time for everything, > 0
  std::string output;                    ///< a folder
  bool plots = true;
  bool open = false;  ///< show the plot
};

/// Reads the arguments; answers --help on standard output and exits.
/// @throws ArgumentError  one line that names the argument
StudyOptions readStudyOptions(int argc, const char* const* argv);

}  // namespace mass_spring
