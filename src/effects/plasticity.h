#pragma once

#include <vector>

#include "mass_spring_sim/model.h"
#include "mass_spring_sim/scene.h"
#include "mass_spring_sim/state.h"

namespace mass_spring {

/// Springs that keep a part of what they are strained by, as bent cables do: beyond the yield
/// strain y, the rest length L of a spring of length l follows by
///   dL/dt = c (M - L),   M = l / (1 + y) where l > (1 + y) L,   M = l / (1 - y) where l < (1 - y)
///   L,
/// Perzyna's law of overstress ("Fundamental problems in viscoplasticity", 1966) for a rest length.
/// Over a step, in which l is that at its end, L moves by 1 - e^(-c h) of the way to M, which it
/// never passes: the energy k (l - L)^2 / 2 only falls, and L stays above 0, whatever c h.
/// Between steps, so that schemes and the analysis of the step matrix see constant springs.
/// @param h             s, since the last time
/// @param springs       those that are left
/// @param count         how many springs there were
/// @param rest_lengths  m, by Spring::number; empty = as in the springs, and stays so while none
///                      yields
void creep(const PlasticityOptions& options, double h, const std::vector<Spring>& springs,
           std::size_t count, const Vectors& positions, std::vector<double>& rest_lengths);

}  // namespace mass_spring
