#include "physics_loop.h"

#include <algorithm>
#include <utility>

#include "conversions.h"

namespace mass_spring {

namespace {

using Seconds = std::chrono::duration<double>;

// After a hiccup, as many steps follow each other without a pause; what is left is never caught up.
constexpr int kMaxCatchUp = 5;

// How long the loop sleeps at most, so that /clock is repeated.
constexpr std::chrono::milliseconds kMaxSleep(100);

const std::string kTimeline = "timeline", kTf = "tf";

}  // namespace

PhysicsLoop::PhysicsLoop(std::shared_ptr<Simulation> simulation, Clock& clock,
                         FrameFollower& follower, Publishers& publishers)
    : clock_(clock),
      follower_(follower),
      publishers_(publishers),
      paused_(simulation->scene().start_paused),
      meter_(simulation->stepSize()),
      ended_(ended_promise_.get_future()) {
  take(std::move(simulation));
}

PhysicsLoop::~PhysicsLoop() {
  queue_.close();
  if (thread_.joinable()) thread_.join();
}

void PhysicsLoop::start() {
  publishers_.started();
  publishers_.paused(paused_);
  thread_ = std::thread([this] {
    run();
    ended_promise_.set_value();
  });
}

bool PhysicsLoop::stop(std::chrono::milliseconds patience) {
  queue_.close();
  return ended_.wait_for(patience) == std::future_status::ready;
}

bool PhysicsLoop::offer(Command command, Answer answer) {
  return queue_.offer([this, command = std::move(command), answer = std::move(answer)] {
    const CommandResult result = simulation_->apply(command);
    if (result.accepted()) redraw_ = true;
    answer(result, simulation_->state().step + 1);
  });
}

/// The result travels by value: a service that gives up waiting leaves nothing dangling behind.
template <class Function>
auto PhysicsLoop::ask(Function function) -> std::future<decltype(function())> {
  using Result = decltype(function());
  auto task = std::make_shared<std::packaged_task<Result()>>(std::move(function));
  auto result = task->get_future();
  queue_.post([task] { (*task)(); });
  return result;
}

std::future<PhysicsLoop::StepOutcome> PhysicsLoop::step(std::uint32_t steps) {
  auto promise = std::make_shared<std::promise<StepOutcome>>();
  auto outcome = promise->get_future();  // the loop may move the promise away at once
  queue_.post([this, steps, promise] {
    finishRequest(false, "interrupted by another call");
    if (paused_) meter_.start(Steady::now());
    request_ = StepRequest{steps, 0, std::move(*promise)};
    if (!paused_) {
      finishRequest(false, "the simulation is running; pause it first");
    } else if (steps == 0) {
      finishRequest(true, "");
    }
  });
  return outcome;
}

std::future<bool> PhysicsLoop::setPaused(bool paused) {
  return ask([this, paused] {
    const bool change = paused != paused_;
    if (change) changePaused(paused);
    return change;
  });
}

std::future<void> PhysicsLoop::reset() {
  return ask([this] {
    finishRequest(false, "interrupted by a reset");
    simulation_->reset();
    startOver();
    publishers_.started();
  });
}

std::future<PhysicsLoop::Replacement> PhysicsLoop::replace(std::shared_ptr<Simulation> simulation) {
  return ask([this, simulation = std::move(simulation)]() mutable {
    Replacement done{simulation->continueFrom(*simulation_), simulation_};
    if (!done.continued) finishRequest(false, "interrupted by a reload");
    take(std::move(simulation));
    if (done.continued) {
      // The period may have become shorter.
      deadline_ = std::min(deadline_, Steady::now() + period_);
    } else {
      meter_ = StepMeter(simulation_->stepSize());
      startOver();
    }
    publishers_.replaced(simulation_, done.continued);
    return done;
  });
}

std::future<std::uint32_t> PhysicsLoop::clearForces() {
  return ask([this] {
    const std::uint32_t count = simulation_->activeForces();
    simulation_->clearForces();
    return count;
  });
}

std::future<std::uint32_t> PhysicsLoop::clearPins() {
  return ask([this] {
    const auto count = static_cast<std::uint32_t>(simulation_->pins().all().size());
    simulation_->clearPins();
    redraw_ = true;
    return count;
  });
}

void PhysicsLoop::redraw() {
  queue_.post([this] { publishers_.redraw(true); });
}

void PhysicsLoop::take(std::shared_ptr<Simulation> simulation) {
  simulation_ = std::move(simulation);
  simulation_->observeTimeline([this](const Command& command, const CommandResult& result) {
    tell(kTimeline, command, result);
  });
  const double factor = simulation_->scene().real_time_factor;
  period_ =
      factor == 0.0
          ? Steady::duration::zero()
          : std::chrono::duration_cast<Steady::duration>(Seconds(simulation_->stepSize() / factor));
}

void PhysicsLoop::tell(const std::string& sender, const Command& command,
                       const CommandResult& result) {
  if (!result.accepted()) {
    publishers_.rejected(sender, sender, result);
    return;
  }
  mass_spring_sim::AppliedCommand message = toMessage(command);
  message.sender = sender;
  message.step = simulation_->state().step + 1;
  publishers_.applied(std::move(message));
}

void PhysicsLoop::startOver() {
  clock_.restart();
  synchronise();
}

void PhysicsLoop::run() {
  synchronise();
  while (!queue_.closed()) {
    for (CommandQueue::Task& task : queue_.take()) task();
    if (stepDue()) {
      advance();
      continue;
    }
    if (std::exchange(redraw_, false) && paused_) publishers_.redraw(false);
    clock_.repeat();
    const Steady::time_point longest = Steady::now() + kMaxSleep;
    queue_.wait(paused_ ? longest : std::min(deadline_, longest));
  }
}

bool PhysicsLoop::stepDue() const {
  if (paused_) return request_.has_value();
  return period_ == Steady::duration::zero() || Steady::now() >= deadline_;
}

void PhysicsLoop::advance() {
  for (const ShapeCommand& command : follower_.lead(*simulation_)) {
    tell(kTf, command, simulation_->apply(command));
  }
  const Steady::time_point begin = Steady::now();
  const StepReport report = simulation_->step();
  const Steady::time_point end = Steady::now();
  if (report.status == StepStatus::kFailed) {
    ROS_ERROR_STREAM("The simulation is paused, as step " << simulation_->state().step + 1
                                                          << " failed: " << report.message);
    if (!paused_) changePaused(true);
    finishRequest(false, report.message);
    return;
  }
  if (report.status == StepStatus::kDegraded && degraded_throttle_.ready()) {
    ROS_WARN_STREAM("Step " << simulation_->state().step << ": " << report.message);
  }
  if (report.broken_springs > 0 && broken_throttle_.ready()) {
    ROS_WARN_STREAM("Step " << simulation_->state().step << ": " << report.broken_springs
                            << " springs broke (" << simulation_->totals().broken_springs
                            << " since the start)");
  }
  clock_.advance(simulation_->state().time);
  meter_.add(end, Seconds(end - begin).count());
  if (period_ > Steady::duration::zero() && end - begin > period_) ++overruns_;
  deadline_ = std::max(deadline_ + period_, end - kMaxCatchUp * period_);
  publishers_.stepped(report, meter_.figures(end), overruns_);
  if (request_ && ++request_->done == request_->steps) finishRequest(true, "");
}

void PhysicsLoop::synchronise() {
  const Steady::time_point now = Steady::now();
  deadline_ = now + period_;
  meter_.start(now);
}

void PhysicsLoop::changePaused(bool paused) {
  paused_ = paused;
  publishers_.paused(paused);
  if (paused) {
    redraw_ = true;
  } else {
    finishRequest(false, "interrupted, as the simulation was set running");
    synchronise();
  }
}

void PhysicsLoop::finishRequest(bool success, const std::string& message) {
  if (!request_) return;
  const std::string progress = " (" + std::to_string(request_->done) + " of " +
                               std::to_string(request_->steps) + " steps done)";
  request_->outcome.set_value({success, success ? message : message + progress,
                               simulation_->state().step, simulation_->state().time});
  request_.reset();
  redraw_ = true;
}

}  // namespace mass_spring
