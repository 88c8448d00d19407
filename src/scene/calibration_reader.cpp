#include "scene/calibration_reader.h"

#include <algorithm>

#include "mass_spring_sim/scene.h"
#include "scene/file_path.h"

namespace mass_spring {
namespace {

std::vector<CalibrationPoint> readPoints(const Place& place) {
  std::vector<CalibrationPoint> points;
  const Tree::List* const list = place.list("a list of points, as accuracy_study writes them");
  if (list == nullptr) return points;
  for (std::size_t i = 0; i < list->size(); ++i) {
    MapReader keys(place.element(i), "a map with accuracy and error");
    CalibrationPoint point{};
    const bool both = keys.required("accuracy").read(point.accuracy, positive("m")) &
                      keys.required("error").read(point.error, positive("m"));
    keys.refuseUnknown();
    if (both) points.push_back(point);
  }
  return points;
}

}  // namespace

void readCalibration(const Place& place, const std::string& directory, SolverOptions& solver) {
  const std::string expected = "a calibration.yaml of accuracy_study";
  if (!place.read(solver.calibration_file, expected)) return;
  if (!solver.accuracy) {
    place.refuse("a calibration only together with an accuracy");
    return;
  }
  try {
    const Tree tree = readYamlFile(findFile(solver.calibration_file, directory).string());
    Problems problems;
    const Place root(&tree, "", true, problems);
    const Tree::Map* const schemes = root.map(expected);
    if (schemes != nullptr && schemes->count(name(solver.scheme)) == 0) {
      std::string known;
      for (const auto& [scheme, points] : *schemes) known += (known.empty() ? "" : ", ") + scheme;
      place.report(solver.calibration_file + ", which was measured with " + known,
                   "points for the scheme " + name(solver.scheme));
      return;
    }
    if (schemes != nullptr) {
      solver.calibration = readPoints(root.child(name(solver.scheme), true));
      if (solver.calibration.empty() && problems.count() == 0) {
        root.refuse("at least one point");
      }
    }
    problems.throwIfAny();
  } catch (const std::runtime_error& error) {  // PathError, SceneError
    place.report(solver.calibration_file + " (" + error.what() + ")", expected);
    return;
  }
  std::sort(
      solver.calibration.begin(), solver.calibration.end(),
      [](const CalibrationPoint& a, const CalibrationPoint& b) { return a.accuracy < b.accuracy; });
}

}  // namespace mass_spring
