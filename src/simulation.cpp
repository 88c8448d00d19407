#include "mass_spring_sim/simulation.h"

#include <algorithm>
#include <cmath>

#include "command_check.h"
#include "loads.h"
#include "stepper.h"

namespace mass_spring {

Simulation::Simulation(Scene scene)
    : scene_(std::move(scene)),
      model_(buildModel(scene_)),
      state_(model_.start),
      pins_(model_.particleCount()),
      loads_(std::make_unique<Loads>(model_.particleCount())),
      stepper_(std::make_unique<Stepper>(model_, model_.solver)) {
  restorePins();
}

Simulation::~Simulation() = default;

std::uint32_t Simulation::activeForces() const { return loads_->active(); }

std::size_t Simulation::matrixNonzeros() const { return stepper_->matrixNonzeros(); }

CommandResult Simulation::apply(const Command& command) {
  return std::visit(
      [this](const auto& c) {
        if constexpr (std::is_same_v<std::decay_t<decltype(c)>, ForceCommand>) {
          return applyForce(c);
        } else {
          return applyPin(c);
        }
      },
      command);
}

CommandResult Simulation::applyForce(const ForceCommand& command) {
  std::vector<std::uint32_t> particles;
  const CommandResult result = checkForce(command, model_, scene_.limits, particles);
  if (!result.accepted()) return result;
  std::uint64_t steps = Loads::kUntilCleared;
  if (command.duration >= 0.0) {
    // 1e-9 of a step: a duration that is meant as whole steps stays so.
    const double whole = std::ceil(command.duration * scene_.rate - 1e-9);
    // Beyond 2^53 steps a double no longer counts them; that is longer than any run.
    steps = static_cast<std::uint64_t>(std::min(std::max(whole, 1.0), 9007199254740992.0));
  }
  loads_->add(command.id, std::move(particles), command.forces, steps);
  return result;
}

CommandResult Simulation::applyPin(const PinCommand& command) {
  std::vector<std::uint32_t> particles;
  const CommandResult result = checkPin(command, model_, state_.positions, particles);
  if (!result.accepted()) return result;
  switch (command.action) {
    case PinCommand::Action::kAdd: {
      const ModelObject& object = model_.objectOf(particles.front());
      return pins_.add(command, object, std::move(particles), state_.positions);
    }
    case PinCommand::Action::kMove:
      return pins_.move(command.name, command.target);
    case PinCommand::Action::kRemove:
      break;
  }
  return pins_.remove(command.name);
}

StepReport Simulation::step() {
  // 1e-9 of a step: a time that is meant as a step boundary is one.
  while (next_timed_command_ < scene_.timeline.size() &&
         scene_.timeline[next_timed_command_].time * scene_.rate <=
             static_cast<double>(state_.step) + 1e-9) {
    const Command& command = scene_.timeline[next_timed_command_++].command;
    const CommandResult result = apply(command);
    if (timeline_observer_) timeline_observer_(command, result);
  }
  const StepReport report = stepper_->step(stepSize(), pins_, loads_->total(), state_);
  totals_.add(report);
  if (report.status == StepStatus::kFailed) return report;
  ++state_.step;
  state_.time = static_cast<double>(state_.step) / scene_.rate;
  loads_->advance();
  return report;
}

void Simulation::reset() {
  state_ = model_.start;
  totals_ = StepTotals();
  next_timed_command_ = 0;
  stepper_->restart();
  clearForces();
  restorePins();
}

void Simulation::clearForces() { loads_->clear(); }

void Simulation::clearPins() { pins_.clear(); }

void Simulation::restorePins() {
  pins_.clear();
  std::vector<std::string> problems;
  for (const ScenePin& pin : scene_.pins) {
    PinCommand command;
    command.name = pin.name;
    command.object = pin.object;
    command.particles = pin.particles;
    command.here = true;
    const CommandResult result = applyPin(command);
    if (!result.accepted()) problems.push_back("pins." + pin.name + "." + result.message);
  }
  if (!problems.empty()) throw SceneError(problems);
}

}  // namespace mass_spring
