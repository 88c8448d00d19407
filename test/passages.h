#pragma once

#include "mass_spring_sim/model.h"

namespace mass_spring {

/// How often particles pass through triangles, and structural springs of objects without triangles
/// through one another, where all particles move evenly from one place to another: by the roots of
/// the volume that the four particles of a pair span. For tests, which must not believe the effect.
int passages(const Model& model, const Vectors& from, const Vectors& to);

}  // namespace mass_spring
