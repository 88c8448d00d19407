#pragma once

#include <string>
#include <vector>

#include "tools/study_run.h"
#include "tools/study_sweep.h"

namespace mass_spring {

/// Errors [m] that the summary names a choice for.
extern const std::vector<double> kStudyErrors;

/// How far the scene can be known, in sentences for its user.
std::string horizonText(const Study& study);

/// m, below which errors cannot be told from the reference's own doubt or spread.
double finestShown(const Study& study);

/// What to choose, and what everything was measured with: Markdown.
/// @param scene_file  as the user named it
std::string summary(const Study& study, const std::vector<StudySeries>& series,
                    const std::string& scene_file);

/// What accuracies asked for gave: YAML for solver.calibration. Empty if none was measured.
std::string calibration(const Study& study, const std::vector<StudyRow>& rows,
                        const std::string& scene_file);

/// What identifies a study, then what the plots need besides the rows: JSON.
std::string studyJson(const Study& study);

/// Processor, memory, system, compiler, versions: lines of Markdown.
std::string describeMachine();

}  // namespace mass_spring
