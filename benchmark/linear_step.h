#pragma once

#include "rival.h"

namespace mass_spring {

/// The linearly implicit step of the course notes by Eigen's conjugate gradients and
/// SimplicialLDLT, and by CHOLMOD, in 1, 2, 4, ... sub-steps (PlainEigen).
std::vector<RivalSeries> linearStepSeries();

}  // namespace mass_spring
