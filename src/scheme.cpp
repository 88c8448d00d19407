#include "mass_spring_sim/scheme.h"

#include <algorithm>

namespace mass_spring {

const std::vector<SchemeInfo>& schemes() {
  static const std::vector<SchemeInfo> table = {
      {Scheme::kExplicitEuler, "explicit_euler", 1, false, false},
      {Scheme::kSymplecticEuler, "symplectic_euler", 1, false, true},
      {Scheme::kRk4, "rk4", 4, false, true},
      {Scheme::kLinearImplicitEuler, "linear_implicit_euler", 1, true, false},
      {Scheme::kImplicitEuler, "implicit_euler", 1, true, false},
      {Scheme::kImplicitMidpoint, "implicit_midpoint", 2, true, false},
      {Scheme::kBdf2, "bdf2", 2, true, false},
      {Scheme::kTrBdf2, "tr_bdf2", 2, true, true},
      {Scheme::kRos3, "ros3", 3, true, true},
  };
  return table;
}

const SchemeInfo& info(Scheme scheme) { return schemes()[static_cast<std::size_t>(scheme)]; }

const std::vector<std::string>& schemeNames() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const SchemeInfo& scheme : schemes()) all.push_back(scheme.name);
    all.push_back("auto");
    return all;
  }();
  return names;
}

const std::string& name(Scheme scheme) { return schemeNames()[static_cast<std::size_t>(scheme)]; }

std::optional<Scheme> schemeFromName(const std::string& name) {
  const auto& names = schemeNames();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return static_cast<Scheme>(found - names.begin());
}

const std::vector<std::string>& linearSolverNames() {
  static const std::vector<std::string> names = {"auto", "conjugate_gradient", "cholesky", "banded",
                                                 "multigrid"};
  return names;
}

const std::string& name(LinearSolver solver) {
  return linearSolverNames()[static_cast<std::size_t>(solver)];
}

std::optional<LinearSolver> linearSolverFromName(const std::string& name) {
  const auto& names = linearSolverNames();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return static_cast<LinearSolver>(found - names.begin());
}

}  // namespace mass_spring
