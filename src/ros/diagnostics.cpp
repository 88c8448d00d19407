#include "diagnostics.h"

#include <utility>

namespace mass_spring {

namespace {

using Level = diagnostic_msgs::DiagnosticStatus;

constexpr std::chrono::seconds kPeriod(1);
// Shares of the real-time factor that was asked for.
constexpr double kSlow = 0.95, kTooSlow = 0.5;
// s. A step that takes longer is told of while it lasts.
constexpr double kLongStep = 2.0;

std::string list(const std::set<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

}  // namespace

Diagnostics::Diagnostics(bool follows_clock) : follows_clock_(follows_clock) {
  updater_.setHardwareID("none");
  updater_.add("timing", this, &Diagnostics::timing);
  updater_.add("solver", this, &Diagnostics::solver);
  updater_.add("state", this, &Diagnostics::state);
  updater_.add("commands", this, &Diagnostics::commands);
  updater_.add("pins", this, &Diagnostics::pins);
  thread_ = std::thread([this] { run(); });
}

Diagnostics::~Diagnostics() {
  change([this](Told&) { stopping_ = true; });
  stopped_.notify_one();
  thread_.join();
}

template <class Change>
void Diagnostics::change(Change change) {
  std::lock_guard lock(mutex_);
  change(told_);
}

void Diagnostics::started(const Simulation& simulation) {
  change([&](Told& told) {
    told.asked_factor = simulation.scene().real_time_factor;
    told.period = told.asked_factor > 0.0 ? simulation.stepSize() / told.asked_factor : 0.0;
    told.measured = false;
    told.particles = simulation.model().particleCount();
    told.totals = simulation.totals();
    told.step = simulation.state().step;
    told.time = simulation.state().time;
    told.pins = simulation.pins().all().size();
    told.report.scheme = simulation.model().solver.scheme;
    told.failure.clear();
    told.last_step = std::chrono::steady_clock::now();
  });
}

void Diagnostics::stepped(const StepReport& report, const StepMeter::Figures& figures,
                          std::uint64_t overruns, const Simulation& simulation,
                          const std::set<std::string>& stale_pins,
                          const std::set<std::string>& stale_shapes) {
  change([&](Told& told) {
    told.figures = figures;
    told.measured = true;
    told.overruns = overruns;
    told.last_step = std::chrono::steady_clock::now();
    told.report = report;
    told.totals = simulation.totals();
    if (report.status == StepStatus::kDegraded) {
      ++told.degraded;
      told.degraded_message = report.message;
    }
    told.step = simulation.state().step;
    told.time = simulation.state().time;
    told.failure.clear();
    told.pins = simulation.pins().all().size();
    if (told.stale_pins != stale_pins) told.stale_pins = stale_pins;
    if (told.stale_shapes != stale_shapes) told.stale_shapes = stale_shapes;
  });
}

void Diagnostics::failed(const std::string& message) {
  change([&](Told& told) { told.failure = message; });
}

void Diagnostics::paused(bool paused) {
  change([&](Told& told) {
    told.paused = paused;
    told.measured = false;
    told.last_step = std::chrono::steady_clock::now();
  });
}

void Diagnostics::applied() {
  change([](Told& told) { ++told.applied; });
}

void Diagnostics::rejected(const std::string& message) {
  change([&](Told& told) {
    ++told.rejected;
    ++told.newly_rejected;
    told.rejected_message = message;
  });
}

void Diagnostics::run() {
  while (true) {
    {
      std::unique_lock lock(mutex_);
      if (stopped_.wait_for(lock, kPeriod, [this] { return stopping_; })) return;
      reported_ = told_;
      told_.degraded = told_.newly_rejected = 0;
    }
    updater_.force_update();
  }
}

void Diagnostics::timing(Status& status) {
  const Told& told = reported_;
  const double factor = told.figures.real_time_factor;
  const std::chrono::duration<double> since = std::chrono::steady_clock::now() - told.last_step;
  if (told.paused) {
    status.summary(Level::OK, "paused");
  } else if (follows_clock_) {
    status.summaryf(Level::OK, "follows /clock: %.2f of real time", factor);
  } else if (since.count() > told.period + kLongStep) {
    status.summaryf(Level::ERROR, "a step has taken %.0f s so far", since.count() - told.period);
  } else if (!told.measured) {
    status.summary(Level::OK, "no step is done yet");
  } else if (told.asked_factor == 0.0) {
    status.summaryf(Level::OK, "as fast as possible: %.2f of real time", factor);
  } else {
    const double share = factor / told.asked_factor;
    status.summaryf(share < kTooSlow ? Level::ERROR
                    : share < kSlow  ? Level::WARN
                                     : Level::OK,
                    "%.3g of real time, %.3g asked for", factor, told.asked_factor);
  }
  status.add("real-time factor", factor);
  status.add("real-time factor asked for", told.asked_factor);
  status.add("step time, median (s)", told.figures.median);
  status.add("step time, longest (s)", told.figures.max);
  status.add("overruns", told.overruns);
}

void Diagnostics::solver(Status& status) {
  const Told& told = reported_;
  if (told.degraded > 0) {
    status.summaryf(Level::WARN, "%llu steps degraded within a second, the last one: %s",
                    static_cast<unsigned long long>(told.degraded), told.degraded_message.c_str());
  } else {
    status.summary(Level::OK, "converged");
  }
  status.add("scheme", name(told.report.scheme));
  status.add("substeps", told.report.substeps);
  status.add("Newton iterations", told.report.newton_iterations);
  status.add("linear iterations", told.report.linear_iterations);
  status.add("residual", told.report.residual);
  status.add("estimated error (m)", told.report.estimated_error);
  status.add("unconverged steps", told.totals.unconverged_steps);
  status.add("rejected steps", told.totals.rejected_steps);
  status.add("broken springs", told.totals.broken_springs);
}

void Diagnostics::state(Status& status) {
  const Told& told = reported_;
  if (told.failure.empty()) {
    status.summary(Level::OK, "finite");
  } else {
    status.summary(Level::ERROR, "paused at the last good state: " + told.failure);
  }
  status.add("step", told.step);
  status.add("simulated time (s)", told.time);
  status.add("particles", told.particles);
}

void Diagnostics::commands(Status& status) {
  const Told& told = reported_;
  if (told.newly_rejected > 0) {
    status.summaryf(Level::WARN, "%llu refused within a second, the last one: %s",
                    static_cast<unsigned long long>(told.newly_rejected),
                    told.rejected_message.c_str());
  } else {
    status.summary(Level::OK, "none refused");
  }
  status.add("applied", told.applied);
  status.add("rejected", told.rejected);
}

void Diagnostics::pins(Status& status) {
  const Told& told = reported_;
  std::string lost;
  if (!told.stale_pins.empty()) lost += "pins " + list(told.stale_pins);
  if (!told.stale_shapes.empty()) {
    lost += (lost.empty() ? "shapes " : "; shapes ") + list(told.stale_shapes);
  }
  if (lost.empty()) {
    status.summary(Level::OK, "all frames known");
  } else {
    status.summary(Level::WARN, "held where they are, as their frames are lost: " + lost);
  }
  status.add("pins", told.pins);
}

}  // namespace mass_spring
