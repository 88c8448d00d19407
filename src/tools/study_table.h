#pragma once

#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "mass_spring_sim/scheme.h"
#include "mass_spring_sim/step_report.h"
#include "tools/modes.h"

namespace mass_spring {

/// What a user can choose, and what accuracy and time depend on.
struct StudySetting {
  Scheme scheme = Scheme::kAuto;
  double rate = 0.0;                       ///< Hz
  int substeps = 1;                        ///< 0 = as the accuracy demands
  std::optional<double> newton_tolerance;  ///< only where the scheme has a Newton iteration
  std::optional<double> accuracy;          ///< m, solver.accuracy

  double stepRate() const { return rate * substeps; }  ///< Hz, of the sub-steps
  bool operator==(const StudySetting& other) const;
};

/// "tr_bdf2, 240 Hz, 2 sub-steps, Newton to 1e-06"
std::string describe(const StudySetting& setting);

/// One setting, measured.
struct StudyRow {
  StudySetting setting;
  double rms_error = 0.0;       ///< m, over the free particles and the frames that can be compared
  double max_error = 0.0;       ///< m, likewise
  double energy_error = 0.0;    ///< J, largest difference of the total energy to the reference's
  double wall_seconds = 0.0;    ///< of all steps of the duration; the median of repetitions
  double step_median = 0.0;     ///< s
  std::string status;           ///< converged, degraded, exploded, failed, refused, unfinished
  double momentum_error = 0.0;  ///< kg m/s, largest difference to the reference's
  double end_energy = 0.0;      ///< J, at the end of the duration, beyond any horizon
  double end_height = 0.0;      ///< m, mean of the particles along -gravity there
  StepTotals totals;            ///< of one run
  std::optional<ModeErrors> mode_errors;  ///< near a shape at rest

  /// Whether its errors mean anything.
  bool usable() const { return status == "converged" || status == "degraded"; }
};

/// results.csv: columns as in the interface, then those that came later.
std::string studyHeader();
std::string toCsv(const StudyRow& row);
/// The rows of a file that a study has left; a last line that is not whole is dropped.
/// @throws std::runtime_error  not such a file
std::vector<StudyRow> readStudyRows(std::istream& file);

/// Of the usable rows, those that no other beats in both error and time: errors fall, times grow.
std::vector<StudyRow> frontier(const std::vector<StudyRow>& rows);
/// The cheapest usable row with an RMS error [m] of at most this; nullptr if there is none.
const StudyRow* cheapest(const std::vector<StudyRow>& rows, double error);
/// The cheapest usable row with errors of the modes of at most this, relative frequency and damping
/// ratio alike; nullptr if there is none.
const StudyRow* cheapestForModes(const std::vector<StudyRow>& rows, double error);

}  // namespace mass_spring
