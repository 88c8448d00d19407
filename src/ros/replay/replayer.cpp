#include "replayer.h"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <sstream>
#include <utility>

#include "mass_spring_sim/scene_reader.h"
#include "ros/conversions.h"

namespace mass_spring {

namespace {

using mass_spring_sim::AppliedCommand;
using mass_spring_sim::ParticleStates;

const std::string kTimeline = "timeline";

/// The runs have parted for good.
struct Parted {};

/// Was the state told before the command took effect?
bool isBefore(const ParticleStates& state, const AppliedCommand* command) {
  return command == nullptr || state.commands < command->number;
}

std::string before(const AppliedCommand& command) {
  return " before step " + std::to_string(command.step);
}

std::string describe(const AppliedCommand& command) {
  const char* const kinds[] = {"force",     "pin",   "shape",  "clear_forces", "clear_pins",
                               "set_state", "reset", "reload", "failed step"};
  const std::string kind = command.kind < std::size(kinds) ? kinds[command.kind] : "unknown";
  return "command " + std::to_string(command.number) + " (" + kind + " of " + command.sender + "," +
         before(command) + ")";
}

std::unique_ptr<Simulation> build(const std::string& scene) {
  return std::make_unique<Simulation>(readScene(readYamlText(scene, "the recorded scene"), ""));
}

Vectors toVectors(const std::vector<double>& numbers) {
  return Eigen::Map<const Vectors>(numbers.data(), 3,
                                   static_cast<Eigen::Index>(numbers.size() / 3));
}

bool same(const AppliedCommand& a, const AppliedCommand& b) {
  return a.kind == b.kind && a.force == b.force && a.pin == b.pin && a.shape == b.shape;
}

}  // namespace

void Replayer::run() {
  take(build(run_.scene()));
  timeline_.startOver(simulation_->scene());
  try {
    for (; run_.command() != nullptr; run_.nextCommand()) {
      follow(*run_.command());
      done_ = run_.command()->number;
      ++comparison_.commands;
    }
    passStates(nullptr);
    finishTold();
  } catch (const Parted&) {
  }
}

void Replayer::follow(const AppliedCommand& command) {
  if (command.step == 0) throw BagError(describe(command) + ": steps count from 1");
  if (command.kind == AppliedCommand::RESET) {
    passStates(&command);
    finishTold();
    checkFirst(command, true);
    simulation_->reset();
    startOver();
  } else if (command.kind == AppliedCommand::RELOAD) {
    reload(command);
  } else {
    advanceTo(command.step - 1, &command);
    checkFirst(command, false);
    if (command.sender == kTimeline) {
      told_.push_back(command);  // the simulation will do it itself
    } else if (command.kind == AppliedCommand::FAILED_STEP) {
      fail(command);
    } else {
      apply(command);
    }
  }
}

void Replayer::apply(const AppliedCommand& command) {
  CommandResult result;
  if (command.kind == AppliedCommand::SET_STATE) {
    result = simulation_->setState(toVectors(command.state.positions),
                                   toVectors(command.state.velocities));
    timeline_.refuse("~set_state" + before(command));
  } else {
    const Command own = toCommand(command);
    result = simulation_->apply(own);
    if (result.accepted()) timeline_.add(command.step, own);
  }
  if (!result.accepted()) {
    comparison_.refused.push_back(describe(command) + " is refused now: " + result.message);
  }
}

void Replayer::reload(const AppliedCommand& command) {
  std::unique_ptr<Simulation> next = build(command.scene);
  // Whether it goes on depends on the two scenes alone; only then is it known up to where.
  const bool continued = next->continueFrom(*simulation_);
  if (continued) {
    advanceTo(command.step - 1, &command);
  } else {
    passStates(&command);
  }
  if (!continued) finishTold();
  checkFirst(command, !continued);
  if (continued) next->continueFrom(*simulation_);
  take(std::move(next));
  if (continued) {
    timeline_.refuse("the ~reload that the run went on with" + before(command));
  } else {
    startOver();
  }
}

void Replayer::take(std::unique_ptr<Simulation> simulation) {
  simulation_ = std::move(simulation);
  comparison_.budget = comparison_.budget || simulation_->scene().solver.budget.has_value();
  simulation_->observeTimeline([this](const Command& command, const CommandResult& result) {
    if (!result.accepted()) return;
    own_applied_.push_back(toMessage(command));
    timeline_.add(simulation_->state().step + 1, command);
  });
}

void Replayer::startOver() {
  ++comparison_.restarts;
  failed_ = 0;
  timeline_.startOver(simulation_->scene());
}

void Replayer::checkFirst(const AppliedCommand& command, bool starts_over) {
  if (!std::exchange(first_, false) || command.number == done_ + 1) return;
  if (command.number <= done_) {
    comparison_.refused.push_back("the scene's timeline gives more commands than it did");
    return;
  }
  const std::uint64_t missed = command.number - done_ - 1;
  if (!starts_over) {
    throw BagError("the recording began late: " + std::to_string(missed) +
                   " commands came before " + describe(command) +
                   ", the first in it. Begin it before them, or with a ~reset");
  }
  comparison_ = Comparison();
  comparison_.budget = simulation_->scene().solver.budget.has_value();
  comparison_.missed_commands = missed;
}

void Replayer::passStates(const AppliedCommand* limit) {
  while (run_.state() != nullptr && isBefore(*run_.state(), limit)) {
    advanceTo(run_.state()->step, limit);
  }
}

void Replayer::advanceTo(std::uint64_t target, const AppliedCommand* limit) {
  if (target < simulation_->state().step) {
    throw BagError("the run falls back from step " + std::to_string(simulation_->state().step) +
                   " to step " + std::to_string(target) + ", but no reset was recorded");
  }
  compareHere(limit);
  while (simulation_->state().step < target) {
    const StepReport report = step();
    if (report.status == StepStatus::kFailed) {
      comparison_.refused.push_back("step " + nextStep() + " fails now: " + report.message);
      throw Parted();
    }
    compareHere(limit);
  }
}

void Replayer::compareHere(const AppliedCommand* limit) {
  for (; run_.state() != nullptr && isBefore(*run_.state(), limit) &&
         run_.state()->step == simulation_->state().step;
       run_.nextState()) {
    if (limit == nullptr) checkCommands(*run_.state());
    compare(*run_.state());
  }
}

void Replayer::checkCommands(const ParticleStates& state) const {
  if (state.commands <= done_) return;
  std::ostringstream message;
  message << "the bag lacks the commands " << done_ + 1 << " to " << state.commands << " of "
          << run_.node() << ", which came before its state of step " << state.step
          << ": they came before the recording began, or had not reached the recorder when it "
             "ended. Of the "
          << comparison_.states << " states before, " << comparison_.differing_states << " differ";
  throw BagError(message.str());
}

void Replayer::compare(const ParticleStates& recorded) {
  ++comparison_.states;
  const State& state = simulation_->state();
  const auto expected = static_cast<std::size_t>(state.positions.size());
  if (recorded.positions.size() != expected || recorded.velocities.size() != expected) {
    comparison_.refused.push_back("the state of step " + std::to_string(recorded.step) + " has " +
                                  std::to_string(recorded.positions.size() / 3) +
                                  " particles, expected " + std::to_string(expected / 3));
    throw Parted();
  }
  std::optional<Difference> first;
  compare(recorded.positions, state.positions, false, first);
  compare(recorded.velocities, state.velocities, true, first);
  if (!first) return;
  ++comparison_.differing_states;
  if (!comparison_.first) comparison_.first = first;
}

void Replayer::compare(const std::vector<double>& recorded, const Vectors& simulated, bool velocity,
                       std::optional<Difference>& first) {
  if (std::memcmp(recorded.data(), simulated.data(), recorded.size() * sizeof(double)) == 0) return;
  const Eigen::Map<const Vectors> was(recorded.data(), 3, simulated.cols());
  for (const ModelObject& object : simulation_->model().objects) {
    for (std::uint32_t k = 0; k < object.particle_count; ++k) {
      const std::uint32_t p = object.first_particle + k;
      if (std::memcmp(&recorded[3 * p], &simulated(0, p), 3 * sizeof(double)) == 0) continue;
      const Difference difference{simulation_->state().step, object.name, k, velocity, was.col(p),
                                  simulated.col(p)};
      if (!first) first = difference;
      if (velocity) return;  // they are told of only where no position differs
      auto& largest = comparison_.largest;
      if (!largest || difference.distance() > largest->distance()) largest = difference;
    }
  }
}

std::string Replayer::nextStep() const { return std::to_string(simulation_->state().step + 1); }

StepReport Replayer::step() {
  const std::uint64_t number = simulation_->state().step + 1;
  const StepReport report = simulation_->step();
  // What was told of has been counted.
  done_ += own_applied_.size() - std::min(own_applied_.size(), told_.size());
  // Where the recording had not begun yet, or ends, it need not tell of them.
  const bool recorded = !told_.empty() || (!first_ && run_.command() != nullptr);
  if (recorded &&
      !std::equal(told_.begin(), told_.end(), own_applied_.begin(), own_applied_.end(), same)) {
    comparison_.refused.push_back("before step " + std::to_string(number) +
                                  " the scene's timeline gave other commands than now");
  }
  told_.clear();
  own_applied_.clear();
  if (report.status == StepStatus::kFailed) {
    failed_ = number;
  } else if (failed_ > 0) {
    timeline_.refuse("how the run went on after step " + std::to_string(failed_) + " had failed");
  }
  return report;
}

void Replayer::finishTold() {
  if (!told_.empty()) step();
}

void Replayer::fail(const AppliedCommand& command) {
  if (step().status == StepStatus::kFailed) return;
  comparison_.refused.push_back("step " + std::to_string(command.step) +
                                " failed, and does not now");
  throw Parted();
}

}  // namespace mass_spring
