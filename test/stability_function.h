#pragma once

#include <Eigen/Core>
#include <optional>

#include "mass_spring_sim/scheme.h"

namespace mass_spring {

/// What a one-step scheme does to u'' = -w^2 u - c u', as a matrix that takes (u, u') over one
/// step: its stability function R(z), written as the theory has it, of z = h [0 1; -w^2 -c].
/// @param w2  w^2 [1/s^2]
/// @param c   1/s
/// @return nullopt for schemes of several steps
std::optional<Eigen::Matrix2d> stabilityFunction(Scheme scheme, double h, double w2, double c);

}  // namespace mass_spring
