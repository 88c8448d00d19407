#include "physics_loop.h"

#include <algorithm>
#include <utility>

#include "conversions.h"
#include "mass_spring_sim/scene_reader.h"

namespace mass_spring {

namespace {

using Seconds = std::chrono::duration<double>;

// After a hiccup, as many steps follow each other without a pause; what is left is never caught up.
constexpr int kMaxCatchUp = 5;

// How long the loop sleeps at most, so that /clock is repeated.
constexpr std::chrono::milliseconds kMaxSleep(100);

const std::string kTimeline = "timeline", kTf = "tf";

using mass_spring_sim::AppliedCommand;

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

bool PhysicsLoop::offer(Command command, std::string topic, std::string sender) {
  return queue_.offer(
      [this, command = std::move(command), topic = std::move(topic), sender = std::move(sender)] {
        const CommandResult result = simulation_->apply(command);
        if (result.accepted()) redraw_ = obeyed_ = true;
        tell(topic, sender, command, result);
      });
}

void PhysicsLoop::observeNames(std::function<void(Names)> observer) {
  queue_.post([this, observer = std::move(observer)] { name_observer_ = observer; });
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

std::future<void> PhysicsLoop::reset(std::string caller) {
  return ask([this, caller = std::move(caller)] {
    finishRequest(false, "interrupted by a reset");
    simulation_->reset();
    startOver();
    tellApplied(caller, AppliedCommand::RESET);
    publishers_.started();
  });
}

std::future<mass_spring_sim::ParticleStates> PhysicsLoop::state() {
  return ask([this] { return publishers_.state(); });
}

std::future<CommandResult> PhysicsLoop::setState(Vectors positions, Vectors velocities,
                                                 std::string caller) {
  return ask([this, positions = std::move(positions), velocities = std::move(velocities),
              caller = std::move(caller)] {
    CommandResult result = simulation_->setState(positions, velocities);
    if (result.accepted()) {
      AppliedCommand message;
      message.kind = AppliedCommand::SET_STATE;
      message.state = publishers_.state();
      tellApplied(caller, std::move(message));
      if (paused_) publishers_.tellAll();
    }
    return result;
  });
}

std::future<PhysicsLoop::Replacement> PhysicsLoop::replace(std::shared_ptr<Simulation> simulation,
                                                           std::string caller) {
  return ask([this, simulation, scene = toYaml(simulation->scene()),
              caller = std::move(caller)]() mutable {
    Replacement done{simulation->continueFrom(*simulation_), simulation_};
    if (!done.continued) finishRequest(false, "interrupted by a reload");
    take(std::move(simulation));
    if (done.continued) {
      // The period may have become shorter.
      if (const auto now = clock_.pace()) deadline_ = std::min(deadline_, *now + period_);
    } else {
      meter_ = StepMeter(simulation_->stepSize());
      startOver();
    }
    AppliedCommand message;
    message.kind = AppliedCommand::RELOAD;
    message.scene = std::move(scene);
    tellApplied(caller, std::move(message));
    publishers_.replaced(simulation_, done.continued);
    return done;
  });
}

std::future<std::uint32_t> PhysicsLoop::clearForces(std::string caller) {
  return ask([this, caller = std::move(caller)] {
    const std::uint32_t count = simulation_->activeForces();
    simulation_->clearForces();
    tellApplied(caller, AppliedCommand::CLEAR_FORCES);
    return count;
  });
}

std::future<std::uint32_t> PhysicsLoop::clearPins(std::string caller) {
  return ask([this, caller = std::move(caller)] {
    const auto count = static_cast<std::uint32_t>(simulation_->pins().all().size());
    simulation_->clearPins();
    tellApplied(caller, AppliedCommand::CLEAR_PINS);
    redraw_ = obeyed_ = true;
    return count;
  });
}

void PhysicsLoop::show(Publishers::Topic topic) {
  queue_.post([this, topic] {
    if (topic == Publishers::Topic::kMarkers) {
      publishers_.drawAnew();
    } else if (paused_) {
      publishers_.tell(topic);
    }
  });
}

void PhysicsLoop::take(std::shared_ptr<Simulation> simulation) {
  simulation_ = std::move(simulation);
  simulation_->observeTimeline([this](const Command& command, const CommandResult& result) {
    tell(kTimeline, kTimeline, command, result);
  });
  double factor = simulation_->scene().real_time_factor;
  if (clock_.followed() && factor == 0.0) factor = 1.0;
  period_ =
      factor == 0.0
          ? Steady::duration::zero()
          : std::chrono::duration_cast<Steady::duration>(Seconds(simulation_->stepSize() / factor));
}

void PhysicsLoop::tell(const std::string& topic, const std::string& sender, const Command& command,
                       const CommandResult& result) {
  if (result.accepted()) {
    tellApplied(sender, toMessage(command));
  } else {
    publishers_.rejected(topic, sender, result);
  }
}

void PhysicsLoop::tellApplied(const std::string& sender, AppliedCommand message) {
  message.sender = sender;
  message.step = simulation_->state().step + 1;
  publishers_.applied(std::move(message));
}

void PhysicsLoop::tellApplied(const std::string& sender, std::uint8_t kind) {
  AppliedCommand message;
  message.kind = kind;
  tellApplied(sender, std::move(message));
}

void PhysicsLoop::tellNames() {
  static const std::vector<ContactShape> kNone;
  const auto& pins = simulation_->pins().all();
  const auto& contact = simulation_->scene().effects.contact;
  const std::vector<ContactShape>& shapes = contact ? contact->shapes : kNone;
  const bool known =
      std::equal(pins.begin(), pins.end(), names_.pins.begin(), names_.pins.end(),
                 [](const auto& pin, const std::string& name) { return pin.first == name; }) &&
      std::equal(
          shapes.begin(), shapes.end(), names_.shapes.begin(), names_.shapes.end(),
          [](const ContactShape& shape, const std::string& name) { return shape.name == name; });
  if (!name_observer_ || known) return;
  names_ = Names();
  for (const auto& [name, pin] : pins) names_.pins.push_back(name);
  for (const ContactShape& shape : shapes) names_.shapes.push_back(shape.name);
  name_observer_(names_);
}

void PhysicsLoop::startOver() {
  clock_.restart(0.0);
  synchronize();
}

void PhysicsLoop::run() {
  synchronize();
  clock_.observe([this] { queue_.wake(); });
  while (!queue_.closed()) {
    for (CommandQueue::Task& task : queue_.take()) task();
    tellNames();
    if (stepDue()) {
      advance();
      continue;
    }
    if (std::exchange(redraw_, false) && paused_) publishers_.tell(Publishers::Topic::kMarkers);
    if (std::exchange(obeyed_, false) && paused_) {
      publishers_.tell(Publishers::Topic::kPins);
      publishers_.tell(Publishers::Topic::kContacts);
    }
    clock_.repeat();
    const Steady::time_point longest = Steady::now() + kMaxSleep;
    queue_.wait(paused_ || clock_.followed() ? longest : std::min(deadline_, longest));
  }
}

bool PhysicsLoop::stepDue() {
  if (paused_) return request_.has_value();
  if (period_ == Steady::duration::zero()) return true;
  const auto now = clock_.pace();
  if (!now) return false;
  if (*now + period_ < deadline_)
    synchronize();  // it jumped back, or is heard of for the first time
  return *now >= deadline_;
}

void PhysicsLoop::advance() {
  for (const Command& command : follower_.lead(*simulation_)) {
    tell(kTf, kTf, command, simulation_->apply(command));
  }
  const std::uint64_t number = simulation_->state().step + 1;
  const auto model = simulation_->sharedModel();
  const Steady::time_point begin = Steady::now();
  const StepReport report = simulation_->step();
  const Steady::time_point end = Steady::now();
  if (report.status == StepStatus::kFailed) {
    ROS_ERROR_STREAM("The simulation is paused, as step " << number
                                                          << " failed: " << report.message);
    clock_.restart(simulation_->state().time);
    // A step that was taken in vain leaves traces: forces have less time left, and solvers start
    // from elsewhere.
    AppliedCommand message;
    message.kind = AppliedCommand::FAILED_STEP;
    message.step = number;
    publishers_.applied(std::move(message));
    publishers_.failed(report, simulation_->sharedModel() != model);
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
  clock_.advance(simulation_->state().time, paused_ ? std::nullopt : std::optional(deadline_));
  meter_.add(end, Seconds(end - begin).count());
  if (period_ > Steady::duration::zero() && end - begin > period_) ++overruns_;
  if (const auto now = clock_.pace()) {
    deadline_ = std::max(deadline_ + period_, *now - kMaxCatchUp * period_);
  }
  publishers_.stepped(report, meter_.figures(end), overruns_);
  if (request_ && ++request_->done == request_->steps) finishRequest(true, "");
}

void PhysicsLoop::synchronize() {
  const auto now = clock_.pace();
  deadline_ = now ? *now + period_ : Clock::Pace::max();
  meter_.start(Steady::now());
}

void PhysicsLoop::changePaused(bool paused) {
  paused_ = paused;
  publishers_.paused(paused);
  if (paused) {
    redraw_ = true;
  } else {
    finishRequest(false, "interrupted, as the simulation was set running");
    synchronize();
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
