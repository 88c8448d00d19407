#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "mass_spring_sim/scene_reader.h"
#include "tools/caught_signal.h"
#include "tools/file_error.h"
#include "tools/simulate_options.h"
#include "tools/study_options.h"
#include "tools/study_progress.h"
#include "tools/study_report.h"
#include "tools/study_run.h"
#include "tools/study_sweep.h"

namespace mass_spring {
namespace {

namespace fs = std::filesystem;

constexpr double kStartsShare = 0.1;     // of the time limit, for starts that part from it
constexpr double kReferenceShare = 0.3;  // of the time limit, after which it is not refined
constexpr const char* kNoBetter = "errs as with a looser Newton tolerance, which costs less";

void writeFile(const fs::path& path, const std::string& text) {
  std::ofstream file(path);
  file << text << std::flush;
  if (!file) throw FileError(path.string());
}

/// All but the reference.
Study read(const StudyOptions& options) {
  Study study;
  study.scene = readSceneWith(options.scene, options.assignments);
  study.duration = options.duration;
  study.frame_rate = frameRate(study.scene, options);
  study.interrupted = [] { return g_signal != 0; };
  const double share = study.scene.rate / study.frame_rate;
  // A reference in whole steps of frames needs a rate that fits them.
  if (std::abs(share - std::round(share)) > 1e-9 * share) study.scene.rate = study.frame_rate;
  stepCount(options.duration, study.scene.rate);
  return study;
}

void addReference(const StudyOptions& options, Study& study) {
  ReferenceOptions reference;
  reference.duration = options.duration;
  reference.frame_rate = study.frame_rate;
  reference.seconds = kReferenceShare * options.time_limit;
  reference.starts_seconds = kStartsShare * options.time_limit;
  reference.interrupted = study.interrupted;
  study.reference = findReference(study.scene, reference);
  study.compared = framesToCompare(study.reference);
  study.modes = findModes(study.scene, study.reference, study.frame_rate, study.compared);
}

/// Makes the folder, before anything takes long.
/// @throws ArgumentError  it holds another study
void openFolder(const fs::path& folder, const Study& study) {
  fs::create_directories(folder);
  if (!fs::exists(folder / "results.csv")) return writeFile(folder / "results.csv", "");
  if (fs::file_size(folder / "results.csv") == 0) return;
  std::ifstream file(folder / "study.json");
  const nlohmann::json before = nlohmann::json::parse(file, nullptr, false);
  const nlohmann::json now = nlohmann::json::parse(studyJson(study));
  for (const char* key : {"version", "scene", "duration", "frame_rate"}) {
    if (before.is_object() && before.contains(key) && before[key] == now[key]) continue;
    throw ArgumentError(folder.string() +
                        " holds the study of another scene, duration or version: give another "
                        "--output, or remove it");
  }
}

/// results.csv of this study: the rows of an earlier, interrupted run, and those to come.
class ResultsFile {
 public:
  /// @throws ArgumentError  what is there is no such file
  ResultsFile(const fs::path& folder, const Study& study) : path_(folder / "results.csv") {
    if (fs::file_size(path_) > 0) {
      std::ifstream file(path_);
      try {
        rows_ = readStudyRows(file);
      } catch (const std::runtime_error& error) {
        throw ArgumentError(path_.string() + ": " + error.what());
      }
    }
    writeFile(folder / "study.json", studyJson(study));
    // Runs that ran out of time may have more of it now.
    rows_.erase(std::remove_if(rows_.begin(), rows_.end(),
                               [](const StudyRow& row) { return row.status == "unfinished"; }),
                rows_.end());
    std::string text = studyHeader() + '\n';
    for (const StudyRow& row : rows_) text += toCsv(row) + '\n';
    writeFile(path_, text);
  }

  const StudyRow* find(const StudySetting& setting) const {
    const auto found = std::find_if(rows_.begin(), rows_.end(),
                                    [&](const StudyRow& row) { return row.setting == setting; });
    return found == rows_.end() ? nullptr : &*found;
  }

  void append(const StudyRow& row) const {
    std::ofstream file(path_, std::ios::app);
    file << toCsv(row) << '\n' << std::flush;
    if (!file) throw FileError(path_.string());
  }

 private:
  fs::path path_;
  std::vector<StudyRow> rows_;
};

StudyRow measureOrRefuse(const Study& study, const StudySetting& setting, double patience) {
  try {
    return measure(study, setting, patience);
  } catch (const SceneError& error) {
    StudyRow row;
    row.setting = setting;
    row.status = "refused";
    for (double* value : {&row.rms_error, &row.max_error, &row.energy_error, &row.momentum_error}) {
      *value = INFINITY;
    }
    std::cerr << "accuracy_study: " << describe(setting) << " refused: " << error.what() << '\n';
    return row;
  }
}

/// Coarse settings of all series first: whatever the time allows, every scheme has its share.
void sweep(const Study& study, const ResultsFile& results, std::vector<StudySeries>& all,
           StudyProgress& progress) {
  const double finest = std::max(kStudyErrors.back(), finestShown(study));
  const auto waits = [&](const StudySeries& series) {
    const StudySeries* looser = looserThan(series, all);
    return looser != nullptr && series.isNoBetterThan(*looser);
  };
  for (bool active = true; active && g_signal == 0;) {
    active = false;
    for (StudySeries& series : all) {
      if (!series.end.empty() || g_signal != 0) continue;
      if (waits(series)) {
        if (!looserThan(series, all)->end.empty()) series.end = kNoBetter;
        continue;
      }
      const StudySetting& setting = series.settings[series.next];
      const auto going =
          static_cast<double>(std::count_if(all.begin(), all.end(), [&](const StudySeries& one) {
            return one.end.empty() && !waits(one);
          }));
      const StudyRow* known = results.find(setting);
      const double share = 2.0 * progress.left() / going;
      if (known == nullptr && !(kStudyRuns * series.prediction() <= share)) {
        series.end = "would take longer than its share of --time-limit";
        continue;
      }
      progress.show(describe(setting));
      const StudyRow row = known ? *known : measureOrRefuse(study, setting, share);
      if (g_signal != 0) return;
      if (known == nullptr) results.append(row);
      progress.print(row);
      series.add(row, finest);
      active = true;
    }
  }
}

/// Runs the script beside this program. @return whether it made the plots
bool plot(const fs::path& folder, bool open) {
  const fs::path script = fs::canonical("/proc/self/exe").parent_path() / "plot_study.py";
  // Another python3 that comes first on PATH may know nothing of matplotlib.
  const char* const python = fs::exists("/usr/bin/python3") ? "/usr/bin/python3" : "python3";
  std::vector<std::string> words = {python, script.string(), folder.string()};
  if (open) words.push_back("--open");
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    execvp(python, arguments.data());
    _exit(127);
  }
  int status = 0;
  return child > 0 && waitpid(child, &status, 0) == child && WIFEXITED(status) &&
         WEXITSTATUS(status) == 0;
}

int study(const StudyOptions& options) {
  StudyProgress progress(options.time_limit);
  catchSignals();
  Study study = read(options);
  const fs::path folder = options.output;
  openFolder(folder, study);
  progress.show("the reference");
  addReference(options, study);
  const ResultsFile results(folder, study);
  std::vector<StudySeries> series = makeSeries(study.scene, options);
  sweep(study, results, series, progress);

  std::vector<StudyRow> rows;
  for (StudySeries& one : series) {
    if (one.end.empty()) one.end = "interrupted";
    rows.insert(rows.end(), one.rows.begin(), one.rows.end());
  }
  writeFile(folder / "summary.md", summary(study, series, options.scene));
  if (const std::string points = calibration(study, rows, options.scene); !points.empty()) {
    writeFile(folder / "calibration.yaml", points);
  }
  if (g_signal != 0) {
    std::cerr << "accuracy_study: interrupted; the same command goes on from here\n";
    return 128 + g_signal;
  }
  if (options.plots && !plot(folder, options.open)) {
    std::cerr << "accuracy_study: no plots: " << folder.string()
              << "/results.csv could not be drawn (is python3-matplotlib installed?)\n";
    return 2;
  }
  std::cout << "\nWhat to choose: " << (folder / "summary.md").string() << '\n';
  return 0;
}

}  // namespace
}  // namespace mass_spring

int main(int argc, char** argv) {
  using namespace mass_spring;
  try {
    return study(readStudyOptions(argc, argv));
  } catch (const SceneError& error) {
    std::cerr << "accuracy_study: scene refused:\n" << error.what() << '\n';
    return 1;
  } catch (const ArgumentError& error) {
    std::cerr << "accuracy_study: " << error.what() << '\n';
    return 1;
  } catch (const std::bad_alloc&) {
    std::cerr << "accuracy_study: not enough memory for this scene\n";
  } catch (const std::exception& error) {
    std::cerr << "accuracy_study: " << error.what() << '\n';
  }
  return g_signal == 0 ? 2 : 128 + g_signal;
}
