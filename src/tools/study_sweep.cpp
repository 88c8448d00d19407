#include "tools/study_sweep.h"

#include <algorithm>
#include <cmath>

namespace mass_spring {
namespace {

constexpr double kLowestRate = 30.0;  // Hz
// From here on finer steps are more sub-steps instead of higher rates, as one would do.
constexpr double kHighestRate = 240.0;
constexpr int kDoublings = 17;
// Of the error, by half the step, twice in a row.
constexpr double kNoGain = 0.7;

bool hasNewton(Scheme scheme) {
  return scheme != Scheme::kAuto && info(scheme).implicit &&
         scheme != Scheme::kLinearImplicitEuler && scheme != Scheme::kRos3;
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
  const double last = rows.back().wall_seconds;
  if (rows.size() < 2 || !rows.back().usable()) return 2.0 * last;
  const double growth = last / rows[rows.size() - 2].wall_seconds;
  return last * std::clamp(growth, 1.0, 4.0);
}

void StudySeries::add(const StudyRow& row, double finest) {
  rows.push_back(row);
  ++next;
  const double error = row.rms_error;
  const auto gain = [&](std::size_t back) {  // by which that row has bettered the one before it
    return rows[rows.size() - 1 - back].rms_error / rows[rows.size() - 2 - back].rms_error;
  };
  if (row.status == "unfinished") {
    end = "took longer than its share of the time";
  } else if (next == settings.size()) {
    end = "all were measured";
  } else if (asked_for || !row.usable()) {
    return;
  } else if (error < 0.1 * finest) {
    end = "far below the finest error of interest";
  } else if (rows.size() > 2 && rows[rows.size() - 3].usable() && gain(0) > kNoGain &&
             gain(1) > kNoGain) {
    end = "no longer gained by finer steps";
  }
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
