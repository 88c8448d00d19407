#pragma once

#include <cstdint>
#include <vector>

#include "solvers/block_pattern.h"

namespace mass_spring {

/// Orders of elimination: the particle at each position. They decide how much a factor fills in.

/// Approximate minimum degree: little fill on any graph, none on trees.
std::vector<std::uint32_t> minimumDegreeOrder(const BlockPattern& pattern);

/// Reverse Cuthill-McKee: neighbors come close to one another, so that the matrix is a band. A
/// chain gets the order of its links however its particles are numbered.
/// (George and Liu, Computer Solution of Large Sparse Positive Definite Systems, 1981, ch. 4.)
std::vector<std::uint32_t> reverseCuthillMcKeeOrder(const BlockPattern& pattern);

/// Block products of one factorization within the band that an order makes of the matrix, all of it
/// filled in.
double bandProducts(const BlockPattern& pattern, const std::vector<std::uint32_t>& order);

}  // namespace mass_spring
