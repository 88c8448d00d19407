#include "tools/study_sweep.h"

#include <algorithm>
#include <cmath>

namespace mass_spring {
namespace {

constexpr double kLowestRate = 30.0;  // Hz
// From here on finer steps are more sub-steps instead of higher rates, as one would do.
constexpr double kHighestRate = 240.0;
constexpr int kDoublings = 17;
// Power of the step that errors fall by, twice in a row. Not of xpbd, which gains once steps are
// short enough for its springs to hear of one another.
constexpr double kNoGain = 0.5;
constexpr const char* kNoLongerGained = "no longer gained by finer steps";
// Two Newton tolerances are as good as one if that many of the finest errors differ by no more.
constexpr std::size_t kCompared = 2;
constexpr double kSame = 1.1;
constexpr double kMostRate = 10000.0;  // Hz, of a scene

bool hasNewton(Scheme scheme) {
  return scheme != Scheme::kAuto && info(scheme).implicit &&
         scheme != Scheme::kLinearImplicitEuler && scheme != Scheme::kRos3 &&
         scheme != Scheme::kXpbd;
}

std::vector<StudySetting> refinements(const Scene& scene, const StudyOptions& options,
                                      Scheme scheme) {
  std::vector<StudySetting> settings;
  if (!options.rates.empty()) {
    for (const double rate : options.rates) {
      settings.push_back({scheme, rate, scene.solver.substeps, {}, {}});
    }
    return settings;
  }
  double rate = frameRate(scene, options);
  int substeps = 1;
  for (int k = 0; k < kDoublings; ++k) {
    settings.push_back({scheme, rate, substeps, {}, {}});
    if (rate < std::max(kHighestRate, scene.rate)) {
      rate *= 2.0;
    } else {
      substeps *= 2;
    }
  }
  return settings;
}

}  // namespace

double StudySeries::prediction() const {
  if (rows.empty()) return 0.0;
  const StudyRow& last = rows.back();
  if (!(settings[next].stepRate() > last.setting.stepRate())) return last.wall_seconds;
  if (rows.size() < 2 || !last.usable()) return 2.0 * last.wall_seconds;
  const double growth = last.wall_seconds / rows[rows.size() - 2].wall_seconds;
  return last.wall_seconds * std::clamp(growth, 1.0, 4.0);
}

std::optional<StudySetting> StudySeries::edge() const {
  const auto stable =
      std::find_if(rows.begin(), rows.end(), [](const StudyRow& row) { return row.usable(); });
  if (asked_for || stable == rows.begin() || stable == rows.end()) return std::nullopt;
  const StudySetting &coarse = (stable - 1)->setting, &fine = stable->setting;
  if (info(fine.scheme).implicit || fine.stepRate() < 1.3 * coarse.stepRate()) return std::nullopt;
  StudySetting between = fine;
  const double step_rate = 0.5 * (coarse.stepRate() + fine.stepRate());
  between.substeps = static_cast<int>(std::lround(step_rate / fine.rate));
  if (between.stepRate() != step_rate) {
    between.substeps = coarse.substeps;
    between.rate = step_rate / coarse.substeps;
  }
  const double share = between.rate / settings.front().rate;  // steps per frame
  return share == std::round(share) && between.rate <= kMostRate
             ? std::optional<StudySetting>(between)
             : std::nullopt;
}

void StudySeries::add(const StudyRow& row, double finest) {
  const auto finer =
      std::upper_bound(rows.begin(), rows.end(), row, [&](const StudyRow& a, const StudyRow& b) {
        return !asked_for && a.setting.stepRate() < b.setting.stepRate();
      });
  rows.insert(finer, row);
  ++next;
  if (const std::optional<StudySetting> between = edge(); between && row.status != "unfinished") {
    settings.insert(settings.begin() + static_cast<std::ptrdiff_t>(next), *between);
    return;
  }
  // By which power of the step that row has bettered the one before it.
  const auto order = [&](std::size_t back) {
    const StudyRow &fine = rows[rows.size() - 1 - back], &coarse = rows[rows.size() - 2 - back];
    return std::log(coarse.rms_error / fine.rms_error) /
           std::log(fine.setting.stepRate() / coarse.setting.stepRate());
  };
  if (row.status == "unfinished") {
    end = "took longer than its share of the time";
  } else if (next == settings.size()) {
    end = "all were measured";
  } else if (asked_for || !rows.back().usable()) {
    return;
  } else if (rows.back().rms_error < 0.1 * finest) {
    end = "far below the finest error of interest";
  } else if (row.setting.scheme != Scheme::kXpbd && rows.size() > 2 &&
             rows[rows.size() - 3].usable() && order(0) < kNoGain && order(1) < kNoGain) {
    end = kNoLongerGained;
  }
}

bool StudySeries::isNoBetterThan(const StudySeries& looser) const {
  if (asked_for || looser.end == kNoLongerGained) return false;
  for (std::size_t back = 0; back < kCompared; ++back) {
    if (back >= rows.size()) return false;
    const StudyRow& row = rows[rows.size() - 1 - back];
    const auto same = std::find_if(looser.rows.begin(), looser.rows.end(), [&](const StudyRow& o) {
      return o.setting.stepRate() == row.setting.stepRate();
    });
    if (same == looser.rows.end() || !same->usable() || !row.usable() ||
        same->rms_error > kSame * row.rms_error ||
        same->totals.newton_iterations > row.totals.newton_iterations) {
      return false;
    }
  }
  return true;
}

const StudySeries* looserThan(const StudySeries& series, const std::vector<StudySeries>& all) {
  if (&series == all.data()) return nullptr;
  const StudySetting &mine = series.settings.front(), &before = (&series - 1)->settings.front();
  return mine.newton_tolerance && mine.scheme == before.scheme ? &series - 1 : nullptr;
}

double frameRate(const Scene& scene, const StudyOptions& options) {
  if (!options.rates.empty()) return options.rates.front();
  double rate = scene.rate;
  while (rate >= 2.0 * kLowestRate) rate *= 0.5;
  return rate;
}

std::vector<StudySeries> makeSeries(const Scene& scene, const StudyOptions& options) {
  std::vector<Scheme> schemes = options.schemes;
  if (schemes.empty()) {
    for (const SchemeInfo& one : mass_spring::schemes()) schemes.push_back(one.scheme);
    schemes.push_back(Scheme::kAuto);
  }
  std::vector<StudySeries> all;
  const auto add = [&](std::vector<StudySetting> settings) {
    all.emplace_back();
    all.back().settings = std::move(settings);
    all.back().asked_for = !options.rates.empty();
  };
  for (const Scheme scheme : schemes) {
    if (scheme == Scheme::kAuto) continue;
    const std::vector<StudySetting> settings = refinements(scene, options, scheme);
    if (!hasNewton(scheme)) {
      add(settings);
      continue;
    }
    for (const double tolerance : options.tolerances) {
      add(settings);
      for (StudySetting& setting : all.back().settings) setting.newton_tolerance = tolerance;
    }
  }
  // Whoever asks for an accuracy asks auto, or a scheme that has an estimate.
  for (const Scheme scheme : schemes) {
    if (scheme != Scheme::kAuto && (scheme != scene.solver.scheme || !info(scheme).estimates)) {
      continue;
    }
    add({});
    all.back().asked_for = true;
    for (const double accuracy : options.accuracies) {
      all.back().settings.push_back({scheme, scene.rate, 0, {}, accuracy});
    }
  }
  return all;
}

}  // namespace mass_spring
