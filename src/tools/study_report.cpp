#include "tools/study_report.h"

#include <sys/utsname.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "mass_spring_sim/scene_reader.h"
#include "tools/study_end.h"

namespace mass_spring {
namespace {

constexpr double kDoubtShare = 0.01;   // of the smallest error that is shown
constexpr double kFinestShown = 1e-7;  // m

std::string number(double value) {
  std::ostringstream text;
  text.precision(3);
  text << value;
  return text.str();
}

/// "0.1 mm"
std::string millimeters(double meters) { return number(1e3 * meters) + " mm"; }

std::string inRealTime(const Study& study, const StudyRow& row) {
  return number(study.duration / row.wall_seconds) + " x real time";
}

std::string cell(const Study& study, const StudyRow* row) {
  if (row == nullptr) return "no setting that was measured | | |";
  return describe(row->setting) + " | " + millimeters(row->rms_error) + " | " +
         number(1e3 * row->step_median) + " ms | " + inRealTime(study, *row);
}

std::string firstLine(const std::string& path, const std::string& key) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (line.compare(0, key.size(), key) == 0) return line.substr(key.size());
  }
  return "";
}

std::vector<StudyRow> allRows(const std::vector<StudySeries>& series) {
  std::vector<StudyRow> rows;
  for (const StudySeries& one : series) rows.insert(rows.end(), one.rows.begin(), one.rows.end());
  return rows;
}

/// The smallest error that runs in real time in steps of at most 1 / rate; of those that are finer
/// than anybody asked for, the cheapest.
const StudyRow* bestInRealTime(const Study& study, const std::vector<StudyRow>& rows, double rate) {
  const StudyRow* best = nullptr;
  for (const StudyRow& row : rows) {
    if (!row.usable() || row.setting.rate < rate || row.wall_seconds > study.duration) continue;
    const auto rank = [](const StudyRow& r) {
      return std::pair(std::max(r.rms_error, kStudyErrors.back()), r.wall_seconds);
    };
    if (best == nullptr || rank(row) < rank(*best)) best = &row;
  }
  return best;
}

/// How well the settings meet the scene's modes.
std::string modesText(const Study& study, const std::vector<StudyRow>& rows) {
  std::ostringstream out;
  out.precision(4);
  out << "\n## Near rest: frequency and damping\n\n";
  if (!study.modes.reason.empty()) {
    out << "No modes of this scene were compared: " << study.modes.reason << ".\n";
    return out.str();
  }
  out << "From " << static_cast<double>(study.modes.first + 1) / study.frame_rate
      << " s on the scene is near a shape at rest. The slowest modes that carry notable energy "
         "there:\n\n| share of the energy | linearized: frequency | damping ratio | the "
         "reference: frequency | damping ratio | not explained |\n|---|---|---|---|---|---|\n";
  // A ratio to the sixth digit; zero without a sign.
  const auto ratio = [](double value) { return std::round(1e6 * value) / 1e6 + 0.0; };
  for (const Mode& mode : study.modes.modes) {
    out << "| " << ratio(mode.share) << " | " << mode.linear.frequency << " Hz | "
        << ratio(mode.linear.damping) << " | " << mode.truth.frequency << " Hz | "
        << ratio(mode.truth.damping) << " | " << ratio(mode.truth.misfit) << " |\n";
  }
  out << "\nThe cheapest setting that errs by no more, relative in frequency and absolute in "
         "damping ratio, on all of them (all settings: mode_frequency_error and mode_damping_error "
         "of results.csv):\n\n| error | setting | of frequency | of damping ratio | speed "
         "|\n|---|---|---|---|---|\n";
  for (const double error : {0.1, 0.01, 0.001}) {
    out << "| " << error << " | ";
    if (const StudyRow* row = cheapestForModes(rows, error)) {
      out << describe(row->setting) << " | " << row->mode_errors->frequency << " | "
          << row->mode_errors->damping << " | " << inRealTime(study, *row) << " |\n";
    } else {
      out << "no setting that was measured | | | |\n";
    }
  }
  return out.str();
}

}  // namespace

const std::vector<double> kStudyErrors = {1e-2, 1e-3, 1e-4, 1e-5};

double finestShown(const Study& study) {
  double spread = 0.0;
  for (std::size_t n = 0; n < study.compared; ++n) {
    spread = std::max(spread, study.reference.spread[n]);
  }
  const double doubt = study.reference.exact ? 0.0 : study.reference.largestDoubt(study.compared);
  return std::max({kFinestShown, doubt / kDoubtShare, spread});
}

std::string horizonText(const Study& study) {
  const Reference& reference = study.reference;
  const std::size_t frames = reference.frames.size();
  std::ostringstream text;
  text.precision(3);
  for (const double error : {1e-2, 1e-3, 1e-4}) {
    const std::size_t n = reference.horizon(error);
    text << "- An error of " << millimeters(error) << " means something "
         << (n == frames ? "to the end, " : "up to ") << static_cast<double>(n) / study.frame_rate
         << " s.\n";
  }
  const std::size_t n = reference.horizon(1e-3);
  if (n == frames) {
    text << "\nTwo starts 1e-9 m apart are " << reference.spread.back()
         << " m apart at the end: that well the scene can be predicted.\n";
  } else {
    text << "\nTwo starts 1e-9 m apart are more than 1 mm apart after "
         << static_cast<double>(n + 1) / study.frame_rate
         << " s: from then on no simulator, nor the real thing, can be repeated to a millimeter, "
            "and only energy, heights and other means are worth comparing.\n";
  }
  return text.str();
}

std::string summary(const Study& study, const std::vector<StudySeries>& series,
                    const std::string& scene_file) {
  const std::vector<StudyRow> rows = allRows(series);
  const Reference& reference = study.reference;
  const double shown = finestShown(study);
  const double until = static_cast<double>(study.compared) / study.frame_rate;
  std::ostringstream out;
  out.precision(3);
  out << "# What accuracy costs: " << scene_file << "\n\n"
      << study.duration << " s simulated; errors are root mean squares over the free particles and "
      << "the " << study.compared << " frames up to " << until << " s.\n\n"
      << "## The cheapest setting\n\n"
      << "| error | setting | its error | step, median | speed |\n|---|---|---|---|---|\n";
  for (const double error : kStudyErrors) {
    out << "| " << millimeters(error) << " | ";
    if (error < 0.99 * shown) {
      out << "below what the reference can tell here, " << millimeters(shown) << " | | | |\n";
    } else {
      out << cell(study, cheapest(rows, error)) << " |\n";
    }
  }
  out << "\n## What real time buys\n\n| steps of at most | setting | its error | step, median | "
         "speed |\n|---|---|---|---|---|\n";
  for (const double rate : {60.0, 240.0}) {
    out << "| 1/" << rate << " s | " << cell(study, bestInRealTime(study, rows, rate)) << " |\n";
  }
  out << modesText(study, rows);
  out << "\n## How far the scene can be known\n\n" << horizonText(study) << "\nThe reference is ";
  if (reference.exact) {
    out << "the closed form of the motion; rk4";
  } else {
    out << "rk4 in " << reference.substeps << " sub-steps of 1/" << reference.rate
        << " s; with half as many it";
  }
  out << " differs by " << reference.largestDoubt(study.compared) << " m at the most up to "
      << until << " s. Errors below " << millimeters(shown) << " are not shown.\n\n";
  out << endText(study, rows) << "\n## Where each scheme was left\n\n"
      << "| scheme | finest setting | its error | speed | why no finer |\n|---|---|---|---|---|\n";
  for (const StudySeries& one : series) {
    if (one.rows.empty()) continue;
    const StudyRow& row = one.rows.back();
    out << "| " << name(row.setting.scheme) << " | " << describe(row.setting) << " | "
        << (row.usable() ? millimeters(row.rms_error) : row.status) << " | "
        << inRealTime(study, row) << " | " << one.end << " |\n";
  }
  out << "\n## Measured with\n\n"
      << describeMachine() << "- solver.linear_tolerance " << study.scene.solver.linear_tolerance
      << ", linear_solver " << name(study.scene.solver.linear_solver) << ", threads "
      << study.scene.solver.threads
      << " (0 = all)\n- times: wall time of the steps, the median of 3 runs where they are short\n";
  return out.str();
}

std::string calibration(const Study& study, const std::vector<StudyRow>& rows,
                        const std::string& scene_file) {
  std::ostringstream out;
  std::vector<Scheme> seen;
  for (const StudyRow& row : rows) {
    const Scheme scheme = row.setting.scheme;
    if (!row.setting.accuracy || std::find(seen.begin(), seen.end(), scheme) != seen.end()) {
      continue;
    }
    seen.push_back(scheme);
    std::ostringstream points;
    for (const StudyRow& point : rows) {
      if (!point.setting.accuracy || point.setting.scheme != scheme || !point.usable()) continue;
      if (!(point.rms_error > 0.0)) continue;
      char text[80];
      std::snprintf(text, sizeof text, "  - {accuracy: %.9e, error: %.9e}\n",
                    *point.setting.accuracy, point.rms_error);
      points << text;
    }
    if (!points.str().empty()) out << name(scheme) << ":\n" << points.str();
  }
  if (out.str().empty()) return "";
  std::ostringstream head;
  head << "# Made by accuracy_study from " << scene_file << ", " << study.duration
       << " s, for solver.calibration:\n# what solver.accuracy (m) gave as error (m) against the "
          "reference.\n";
  return head.str() + out.str();
}

std::string studyJson(const Study& study) {
  const Reference& reference = study.reference;
  nlohmann::json horizon;
  for (const double error : kStudyErrors) {
    horizon.push_back(
        {{"error_m", error},
         {"seconds", static_cast<double>(reference.horizon(error)) / study.frame_rate}});
  }
  const nlohmann::json json = {
      {"version", MASS_SPRING_VERSION},
      {"scene", toYaml(study.scene)},
      {"duration", study.duration},
      {"frame_rate", study.frame_rate},
      {"compared_seconds", static_cast<double>(study.compared) / study.frame_rate},
      {"finest_shown_m", finestShown(study)},
      {"reference_exact", reference.exact},
      {"reference_substeps", reference.substeps},
      {"reference_doubt_m", reference.largestDoubt(study.compared)},
      {"horizon", horizon},
  };
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

std::string describeMachine() {
  std::ostringstream out;
  utsname system{};
  uname(&system);
  std::string processor = firstLine("/proc/cpuinfo", "model name");
  processor.erase(0, processor.find_first_not_of("\t :"));
  out << "- processor: " << (processor.empty() ? "unknown" : processor) << ", "
      << std::thread::hardware_concurrency() << " cores, " << system.machine
      << "\n- system: " << system.sysname << ' ' << system.release << "\n- compiler: "
      <<
#if defined(__clang__)
      "Clang " << __clang_version__
#else
      "GCC " << __VERSION__
#endif
#if defined(NDEBUG)
      << ", optimized"
#else
      << ", not optimized"
#endif
      << "\n- mass_spring_sim " << MASS_SPRING_VERSION << ", Eigen " << EIGEN_WORLD_VERSION << '.'
      << EIGEN_MAJOR_VERSION << '.' << EIGEN_MINOR_VERSION << '\n';
  return out.str();
}

}  // namespace mass_spring
