#pragma once

#include <string>
#include <vector>

#include "tools/study_run.h"

namespace mass_spring {

/// What some equally likely runs came to.
struct Statistics {
  double mean = 0.0;
  double deviation = 0.0;  ///< standard deviation of one; 0 if there is but one

  /// Standard deviations from the mean; 0 at the mean.
  double deviations(double value) const;
};
Statistics statistics(const std::vector<double>& values);

/// Standard deviations within which one more run falls 19 times in 20.
/// @param runs  that the deviation is of, [2, kStarts]
double usualDeviations(std::size_t runs);

/// Energy and mean height at the end of a study, of its reference and its settings: a paragraph,
/// with a table where no position can be predicted any more.
std::string endText(const Study& study, const std::vector<StudyRow>& rows);

}  // namespace mass_spring
