#include "rival_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <set>

#include "mass_spring_sim/scene.h"
#include "scheme_choice.h"
#include "tools/study_sweep.h"

namespace mass_spring {
namespace {

// m, of interest: one more than accuracy_study has, as rivals are meant for looks.
constexpr double kErrors[] = {1e-1, 1e-2, 1e-3, 1e-4, 1e-5};
constexpr int kRounds = 5;
constexpr double kLong = 2.0;       // s: runs that are not repeated
constexpr double kExploded = 10.0;  // extents of the scene, of an error

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double simulatedSeconds(const Study& study) {
  return static_cast<double>(study.reference.frames.size()) / study.frame_rate;
}

/// One run; its time [s] is that of the steps alone.
RivalRow runOnce(const Study& study, const RivalScene& scene, const RivalSetting& setting,
                 double patience) {
  RivalRow row;
  row.setting = setting.text;
  row.status = "converged";
  const std::unique_ptr<Rival> rival = setting.make(scene);
  const auto steps_per_frame = std::lround(1.0 / (scene.step * study.frame_rate));
  double square = 0.0;
  const auto stop = [&](const char* status) {
    row.status = status;
    row.rms_error = row.max_error = INFINITY;
    return row;
  };
  for (std::size_t frame = 0; frame < study.reference.frames.size(); ++frame) {
    for (long step = 0; step < steps_per_frame; ++step) {
      const double start = now();
      rival->step();
      row.seconds += now() - start;
      if (row.seconds > patience) return stop("unfinished");
    }
    const Vectors positions = rival->positions();
    const Vectors& truth = study.reference.frames[frame].positions;
    const double distance = study.reference.distance(positions, truth);
    // None ever says so, and Bullet even makes zeros of NaN: it can only be seen.
    if (!(distance < kExploded * extent(study.reference))) return stop("exploded");
    if (frame >= study.compared) continue;
    square += distance * distance;
    for (Eigen::Index i = 0; i < positions.cols(); ++i) {
      if (study.reference.pinned[static_cast<std::size_t>(i)]) continue;
      row.max_error = std::max(row.max_error, (positions.col(i) - truth.col(i)).norm());
    }
  }
  // Each frame has as many free particles.
  row.rms_error = std::sqrt(square / static_cast<double>(study.compared));
  return row;
}

/// The median time of as many runs as accuracy_study does.
RivalRow measureRival(const Study& study, const RivalScene& scene, const RivalSetting& setting,
                      double patience) {
  RivalRow row = runOnce(study, scene, setting, patience);
  std::vector<double> seconds = {row.seconds};
  while (row.usable() && seconds.size() < kStudyRuns && row.seconds < kLong) {
    seconds.push_back(runOnce(study, scene, setting, INFINITY).seconds);
  }
  std::nth_element(seconds.begin(), seconds.begin() + seconds.size() / 2, seconds.end());
  row.seconds = seconds[seconds.size() / 2];
  return row;
}

/// How a series of a rival goes on.
class Progress {
 public:
  Progress(double time_limit, double finest) : end_(now() + time_limit), finest_(finest) {}

  double left() const { return end_ - now(); }
  /// Whether the next setting can be expected to be measured in time.
  bool hasTime() const {
    if (walls_.empty()) return true;
    const double last = walls_.back();
    const double growth =
        walls_.size() > 1 ? std::clamp(last / walls_[walls_.size() - 2], 1.0, 4.0) : 2.0;
    const double next = last * growth;
    return (next < kLong ? kStudyRuns : 1) * next < left();
  }
  /// @return whether a finer setting would teach anything. Unlike accuracy_study's, a series that
  /// gains nothing for a while goes on: nobody shall say that a rival was stopped too early.
  bool add(const RivalRow& row) {
    walls_.push_back(row.seconds);
    return row.status != "unfinished" && row.rms_error >= 0.1 * finest_;
  }

 private:
  double end_, finest_;
  std::vector<double> walls_;
};

/// What accuracy_study goes through. Explicit schemes are best right below their limit of
/// stability, so that powers of two alone would miss that by up to a factor of two, as the rivals'
/// steps do not; and far beyond it runs only explode, which takes the time of others. Nor are the
/// rivals' position based steps twice as fine each time.
std::vector<StudySeries> ourSeries(const Scene& scene) {
  StudyOptions options;
  options.tolerances = {1e-2, 1e-4, 1e-6};
  options.accuracies = {1e-2, 1e-3, 1e-4, 1e-5};
  std::vector<StudySeries> all = makeSeries(scene, options);
  for (const Scheme scheme : {Scheme::kSymplecticEuler, Scheme::kRk4}) {
    StudySeries between;
    for (int octave = 1; octave <= 1 << 12; octave *= 2) {
      for (const int n : {5, 6, 7}) {
        between.settings.push_back({scheme, 240.0, n * octave, {}, {}});
      }
    }
    all.push_back(between);
  }
  StudySeries between;
  for (int substeps = 1; substeps <= 1 << 12; substeps *= 2) {
    between.settings.push_back({Scheme::kXpbd, 3.0 * frameRate(scene, options), substeps, {}, {}});
  }
  all.push_back(between);
  const SpectrumBounds bounds = boundSpectrum(buildModel(scene));
  for (StudySeries& series : all) {
    const Scheme scheme = series.settings[0].scheme;
    if (scheme == Scheme::kAuto || info(scheme).implicit) continue;
    const double stable =
        scheme == Scheme::kRk4 ? stableRk4Step(bounds) : stableSymplecticStep(bounds);
    auto& settings = series.settings;
    settings.erase(std::remove_if(settings.begin(), settings.end() - 1,
                                  [&](const StudySetting& setting) {
                                    return setting.rate * setting.substeps * stable < 0.5;
                                  }),
                   settings.end() - 1);
  }
  return all;
}

RivalRow leftOut(const std::string& setting) {
  RivalRow row;
  row.setting = setting;
  row.rms_error = row.max_error = row.seconds = INFINITY;
  row.status = "unfinished";
  return row;
}

const RivalRow* cheapest(const std::vector<RivalRow>& rows, bool ours, double error) {
  const RivalRow* best = nullptr;
  for (const RivalRow& row : rows) {
    if (row.ours != ours || !row.usable() || !(row.rms_error <= error)) continue;
    if (best == nullptr || row.seconds < best->seconds) best = &row;
  }
  return best;
}

/// Other programs slow this one at one time and not at another: whoever is cheapest for an error of
/// interest is timed again, all of them in turn, and the fastest run of each counts.
/// @param again  per row, s per simulated second of another run
void timeWinnersAgain(std::vector<RivalRow>& rows,
                      const std::vector<std::function<double()>>& again) {
  std::set<std::size_t> winners;
  for (const double error : kErrors) {
    for (const bool ours : {true, false}) {
      const RivalRow* winner = cheapest(rows, ours, error);
      if (winner != nullptr) winners.insert(static_cast<std::size_t>(winner - rows.data()));
    }
  }
  for (int round = 0; round < kRounds; ++round) {
    for (const std::size_t k : winners) rows[k].seconds = std::min(rows[k].seconds, again[k]());
  }
}

/// Commas part columns.
std::string withoutCommas(std::string text) {
  std::replace(text.begin(), text.end(), ',', ';');
  return text;
}

std::string describe(const RivalRow* row) {
  if (row == nullptr) return "none | ";
  char text[200];
  std::snprintf(text, sizeof text, "%s (%s) | %.3g", row->contender.c_str(), row->setting.c_str(),
                row->seconds);
  return text;
}

}  // namespace

std::vector<RivalRow> measureAll(const Study& study, const std::string& name,
                                 const std::vector<RivalSeries>& rivals,
                                 const RivalRunOptions& options) {
  const double simulated = simulatedSeconds(study);
  std::vector<RivalRow> rows;
  std::vector<std::function<double()>> again;
  const auto add = [&](RivalRow row, const std::string& contender, bool ours,
                       std::function<double()> run) {
    row.scene = name;
    row.contender = contender;
    row.ours = ours;
    row.seconds /= simulated;
    rows.push_back(row);
    again.push_back([=] { return run() / simulated; });
    std::printf("%-14s %-36s %-44s %10.3g m %10.3g s/s  %s\n", name.c_str(), contender.c_str(),
                row.setting.c_str(), row.rms_error, row.seconds, row.status.c_str());
    std::fflush(stdout);
  };

  for (StudySeries& series : ourSeries(study.scene)) {
    const std::string contender = "ours: " + mass_spring::name(series.settings[0].scheme);
    const double end = now() + options.time_limit;
    while (series.end.empty()) {
      const StudySetting& setting = series.settings[series.next];
      const std::string text = withoutCommas(mass_spring::describe(setting));
      const double next = series.prediction(), left = end - now();
      if (!((next < kLong ? kStudyRuns : 1) * next < left)) {
        add(leftOut(text), contender, true, [] { return INFINITY; });
        break;
      }
      RivalRow row;
      row.setting = text;
      try {
        const StudyRow measured = measure(study, setting, left);
        row.rms_error = measured.rms_error;
        row.max_error = measured.max_error;
        row.seconds = measured.wall_seconds;
        row.status = measured.status;
        series.add(measured, options.finest);
      } catch (const SceneError&) {
        row = leftOut(text);
        row.status = "refused";
        series.end = "refused";
      }
      add(row, contender, true,
          [&study, setting] { return measure(study, setting, INFINITY).wall_seconds; });
    }
  }

  Scene scene = study.scene;
  scene.solver.scheme = Scheme::kRk4;  // needs no matrix
  const Model model = buildModel(scene);
  const Eigen::Vector3d gravity =
      scene.effects.gravity ? scene.effects.gravity->acceleration : Eigen::Vector3d::Zero();
  const RivalScene rival_scene{model, gravity, study.reference.pinned, 1.0 / scene.rate};
  for (const RivalSeries& series : rivals) {
    Progress progress(options.time_limit, options.finest);
    for (const RivalSetting& setting : series.settings) {
      if (!progress.hasTime()) {
        add(leftOut(setting.text), series.name, false, [] { return INFINITY; });
        break;
      }
      const RivalRow row = measureRival(study, rival_scene, setting, progress.left());
      add(row, series.name, false,
          [&, setting] { return runOnce(study, rival_scene, setting, INFINITY).seconds; });
      if (!progress.add(row)) break;
    }
  }
  timeWinnersAgain(rows, again);
  return rows;
}

std::string rivalHeader() {
  return "scene,contender,setting,rms_error_m,max_error_m,seconds_per_simulated_second,status";
}

std::string toCsv(const RivalRow& row) {
  char numbers[120];
  std::snprintf(numbers, sizeof numbers, "%.9g,%.9g,%.6g", row.rms_error, row.max_error,
                row.seconds);
  return row.scene + ',' + row.contender + ',' + row.setting + ',' + numbers + ',' + row.status;
}

std::string rivalTable(const std::vector<RivalRow>& rows, double finest_shown) {
  std::string table =
      "| error, mm | cheapest of ours | s per simulated s | cheapest rival | s per simulated s | "
      "the rival takes times |\n|---|---|---|---|---|---|\n";
  for (const double error : kErrors) {
    char text[60];
    std::snprintf(text, sizeof text, "| %g | ", 1e3 * error);
    table += text;
    if (error < finest_shown) {
      table += "not to be told on this scene | | | | |\n";
      continue;
    }
    const RivalRow *ours = cheapest(rows, true, error), *theirs = cheapest(rows, false, error);
    table += describe(ours) + " | " + describe(theirs) + " | ";
    if (ours != nullptr && theirs != nullptr) {
      std::snprintf(text, sizeof text, "%.2f", theirs->seconds / ours->seconds);
      table += text;
    }
    table += " |\n";
  }
  return table;
}

}  // namespace mass_spring
