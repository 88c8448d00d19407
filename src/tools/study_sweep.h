#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/study_options.h"
#include "tools/study_run.h"

namespace mass_spring {

/// One scheme, with one Newton tolerance, at ever finer steps; or auto at ever smaller accuracies.
struct StudySeries {
  std::vector<StudySetting> settings;  ///< coarse first
  bool asked_for = false;              ///< each of them: none is left out as needless
  std::size_t next = 0;                ///< of settings
  std::vector<StudyRow> rows;          ///< of the settings before it
  std::string end;                     ///< why no finer one is measured; empty while it goes on

  /// What the next setting will take [s], by the last two.
  double prediction() const;
  /// Takes a row, and ends the series where a finer setting would teach nothing.
  /// @param finest  m, the smallest error of interest
  void add(const StudyRow& row, double finest);
};

/// The lowest rate that a study of a scene compares at: the scene's own, halved down to 30 Hz, or
/// the lowest one asked for.
double frameRate(const Scene& scene, const StudyOptions& options);

/// All series of a study, in the order of the schemes.
std::vector<StudySeries> makeSeries(const Scene& scene, const StudyOptions& options);

}  // namespace mass_spring
