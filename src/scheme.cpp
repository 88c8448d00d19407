#include "mass_spring_sim/scheme.h"

#include <algorithm>
#include <cmath>

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
      {Scheme::kXpbd, "xpbd", 1, true, false},
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

std::optional<double> controlledAccuracy(const SolverOptions& options) {
  if (!options.accuracy || options.calibration.empty()) return options.accuracy;
  const std::vector<CalibrationPoint>& points = options.calibration;
  const double wanted = *options.accuracy;
  for (std::size_t i = points.size(); i-- > 0;) {
    if (points[i].error > wanted) continue;
    if (i + 1 == points.size()) return points[i].accuracy;
    const CalibrationPoint &fine = points[i], &coarse = points[i + 1];
    const double share = std::log(wanted / fine.error) / std::log(coarse.error / fine.error);
    return fine.accuracy * std::pow(coarse.accuracy / fine.accuracy, share);
  }
  return points.front().accuracy * wanted / points.front().error;
}

}  // namespace mass_spring
