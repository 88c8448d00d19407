#pragma once

#include <string>
#include <vector>

#include "hard_cases_watch.h"

namespace mass_spring {

/// Which schemes a case is run with.
enum class Applies {
  kToNone,  ///< no steps are made
  kToAll,   ///< explicit ones only unscaled, at the row's explicit_step
  kToImplicit,
  kToSummers,  ///< all but xpbd: forces of springs add up
  kToSolvers,  ///< implicit ones that solve for all springs at once
  kToDamping,  ///< implicit ones that damp what is stiff: the case has to come to rest
};

/// One row of the table of hard cases: an input that breaks plain code, and what has to hold.
struct HardCase {
  int number;              ///< as in docs/stability.md
  std::string name;        ///< the failure it guards against, then the input
  std::string plain_code;  ///< what that does
  Applies applies;
  std::vector<double> stiffness;  ///< factors, each with each of
  std::vector<double> steps;      ///< s
  double explicit_step;           ///< s; 0 = not for explicit schemes
  void (*run)(Trial& trial);      ///< builds the scene, steps it, checks the criterion
};

const std::vector<HardCase>& hardCases();

/// The runs of a row: a name `scheme/parameters` and its parameters each.
std::vector<Trial> trials(const HardCase& row);

}  // namespace mass_spring
