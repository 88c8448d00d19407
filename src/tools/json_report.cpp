#include "tools/json_report.h"

#include "mass_spring_sim/scheme.h"

namespace mass_spring {
namespace {

nlohmann::json json(const Energy& energy) {
  return {{"kinetic", energy.kinetic},
          {"elastic", energy.elastic},
          {"gravity", energy.gravity},
          {"total", energy.total()}};
}

nlohmann::json json(const std::map<std::string, Wrench>& wrenches) {
  nlohmann::json object = nlohmann::json::object();
  const auto list = [](const Eigen::Vector3d& v) {
    return nlohmann::json::array({v.x(), v.y(), v.z()});
  };
  for (const auto& [name, wrench] : wrenches) {
    object[name] = {{"force", list(wrench.force)}, {"torque", list(wrench.torque)}};
  }
  return object;
}

nlohmann::json orNull(double value) {
  return value < 0.0 ? nlohmann::json() : nlohmann::json(value);
}

}  // namespace

nlohmann::json jsonReport(const Simulation& simulation, const RunStatistics& statistics) {
  const StepTotals& totals = simulation.totals();
  const StepTimes& times = statistics.step_times;
  nlohmann::json report = {
      {"scheme", name(simulation.model().solver.scheme)},
      {"scheme_reason", simulation.model().scheme_reason},
      {"steps", simulation.state().step},
      {"substeps_total", totals.substeps},
      {"simulated_seconds", simulation.state().time},
      {"wall_seconds", statistics.wall_seconds},
      {"setup_seconds", statistics.setup_seconds},
      {"step_seconds",
       {{"median", times.quantile(0.5)}, {"p99", times.quantile(0.99)}, {"max", times.max()}}},
      {"particles", simulation.model().particleCount()},
      {"springs", simulation.model().springs.size()},
      {"effects", simulation.model().effectNames()},
      {"newton_iterations", totals.newton_iterations},
      {"linear_iterations", totals.linear_iterations},
      {"factorizations", totals.factorizations},
      {"matrix_nonzeros", simulation.matrixNonzeros()},
      {"unconverged_steps", totals.unconverged_steps},
      {"rejected_steps", totals.rejected_steps},
      {"estimated_error", orNull(totals.estimated_error)},
      {"max_budget_used", orNull(totals.max_budget_used)},
      {"energy",
       {{"start", json(statistics.start_energy)},
        {"end", json(simulation.energy())},
        {"max_total", statistics.max_energy}}},
      {"max_stretch", statistics.max_stretch},
      {"pins", json(simulation.pinWrenches())},
      {"status", name(statistics.status)},
      {"message", statistics.message()},
  };
  if (simulation.scene().effects.tearing) report["broken_springs"] = totals.broken_springs;
  const auto shapes = simulation.shapeWrenches();
  if (!shapes.empty()) report["shapes"] = json(shapes);
  return report;
}

}  // namespace mass_spring
