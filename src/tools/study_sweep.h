#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/study_options.h"
#include "tools/study_run.h"

namespace mass_spring {

/// One scheme, with one Newton tolerance, at ever finer steps, and where it turns stable between
/// them; or auto at ever smaller accuracies.
struct StudySeries {
  std::vector<StudySetting> settings;  ///< coarse first, but for those about the edge of stability
  bool asked_for = false;              ///< each of them: none is left out as needless
  std::size_t next = 0;                ///< of settings
  std::vector<StudyRow> rows;          ///< of the settings before it, coarse first
  std::string end;                     ///< why no finer one is measured; empty while it goes on

  /// What the next setting will take [s], by the finest two.
  double prediction() const;
  /// Takes a row, and ends the series where a finer setting would teach nothing.
  /// @param finest  m, the smallest error of interest
  void add(const StudyRow& row, double finest);
  /// Whether its finest rows err as with a looser Newton tolerance, which costs no more: as long as
  /// that gains by finer steps, it is not the tolerance that it errs by.
  bool isNoBetterThan(const StudySeries& looser) const;

 private:
  /// Between the finest unstable setting and the coarsest stable one of an explicit scheme, as long
  /// as their steps differ by a third, and there is one in whole steps a frame.
  std::optional<StudySetting> edge() const;
};

/// The series before it, if that differs in nothing but a looser Newton tolerance; else nullptr.
const StudySeries* looserThan(const StudySeries& series, const std::vector<StudySeries>& all);

/// The lowest rate that a study of a scene compares at: the scene's own, halved down to 30 Hz, or
/// the lowest one asked for.
double frameRate(const Scene& scene, const StudyOptions& options);

/// All series of a study, in the order of the schemes.
std::vector<StudySeries> makeSeries(const Scene& scene, const StudyOptions& options);

}  // namespace mass_spring
