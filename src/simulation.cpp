#include "mass_spring_sim/simulation.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "command_check.h"
#include "effects/contact.h"
#include "effects/plasticity.h"
#include "effects/springs.h"
#include "effects/tearing.h"
#include "loads.h"
#include "stepper.h"

namespace mass_spring {

namespace {

/// Nothing but colors, stiffnesses, damping, effects and the solver may differ.
bool sameObjects(const Model& a, const Model& b) {
  const auto object = [](const ModelObject& o) { return std::tie(o.name, o.particle_count); };
  const auto spring = [](const Spring& s) { return std::tie(s.i, s.j, s.rest_length, s.kind); };
  // Vectors of other lengths compare as different here; Eigen's would be an error.
  const auto equal = [](const auto& left, const auto& right, const auto& key) {
    return std::equal(left.begin(), left.end(), right.begin(), right.end(),
                      [&](const auto& l, const auto& r) { return key(l) == key(r); });
  };
  return equal(a.objects, b.objects, object) && equal(a.springs, b.springs, spring) &&
         a.triangles == b.triangles && a.masses == b.masses &&
         a.start.positions == b.start.positions && a.start.velocities == b.start.velocities;
}

bool samePins(const std::vector<ScenePin>& a, const std::vector<ScenePin>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const ScenePin& l, const ScenePin& r) {
                      return std::tie(l.name, l.object, l.particles, l.follow_frame) ==
                             std::tie(r.name, r.object, r.particles, r.follow_frame);
                    });
}

}  // namespace

Simulation::Simulation(Scene scene)
    : scene_(std::move(scene)),
      whole_(std::make_shared<Model>(buildModel(scene_))),
      state_(whole_->start),
      pins_(whole_->particleCount()),
      loads_(std::make_unique<Loads>(whole_->particleCount())) {
  if (scene_.effects.plasticity) rest_lengths_.reserve(whole_->springs.size());
  take(whole_);
  restorePins();
}

Simulation::~Simulation() = default;

std::uint32_t Simulation::activeForces() const { return loads_->active(); }

std::size_t Simulation::matrixNonzeros() const { return stepper_->matrixNonzeros(); }

std::map<std::string, Wrench> Simulation::pinWrenches() const {
  return mass_spring::pinWrenches(*model_, state_, pins_, loads_->total());
}

std::map<std::string, Wrench> Simulation::shapeWrenches() const {
  return mass_spring::shapeWrenches(*model_, state_);
}

std::vector<Touch> Simulation::touches() const { return mass_spring::touches(*model_, state_); }

CommandResult Simulation::apply(const Command& command) {
  return std::visit(
      [this](const auto& c) {
        if constexpr (std::is_same_v<std::decay_t<decltype(c)>, ForceCommand>) {
          return applyForce(c);
        } else if constexpr (std::is_same_v<std::decay_t<decltype(c)>, PinCommand>) {
          return applyPin(c);
        } else if constexpr (std::is_same_v<std::decay_t<decltype(c)>, ShapeCommand>) {
          return applyShape(c);
        } else {
          return applyClear(c);
        }
      },
      command);
}

CommandResult Simulation::applyForce(const ForceCommand& command) {
  std::vector<std::uint32_t> particles;
  const CommandResult result = checkForce(command, *model_, scene_.limits, particles);
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
  const CommandResult result = checkPin(command, *model_, state_.positions, particles);
  if (!result.accepted()) return result;
  switch (command.action) {
    case PinCommand::Action::kAdd: {
      const ModelObject& object = model_->objectOf(particles.front());
      return pins_.add(command, object, std::move(particles), state_.positions);
    }
    case PinCommand::Action::kMove: {
      const auto found = pins_.all().find(command.name);
      const CommandResult reach = found == pins_.all().end()
                                      ? CommandResult()
                                      : checkPinTarget(found->second, command.target, *model_,
                                                       state_.positions, stepSize());
      return reach.accepted() ? pins_.move(command) : reach;
    }
    case PinCommand::Action::kRemove:
      break;
  }
  return pins_.remove(command.name);
}

CommandResult Simulation::applyShape(const ShapeCommand& command) {
  const CommandResult result = checkShape(command, *model_, state_, stepSize());
  if (!result.accepted()) return result;
  Shape& shape = *model_->contact->find(command.name);
  shape.move(RigidMotion(shape.motion().at(state_.time), command.target, state_.time,
                         std::max(command.duration, stepSize())));
  return result;
}

CommandResult Simulation::applyClear(const ClearCommand& command) {
  command.what == ClearCommand::What::kForces ? clearForces() : clearPins();
  return {};
}

StepReport Simulation::step() {
  // After a step that failed, the state may be an earlier one.
  timeline_steps_ = std::max(timeline_steps_, static_cast<double>(state_.step));
  while (timelineDue(timeline_steps_)) {
    const Command& command = scene_.timeline[next_timed_command_++].command;
    const CommandResult result = apply(command);
    if (timeline_observer_) timeline_observer_(command, result);
  }
  if (stepper_->mayExplode() && !kept_) keep();
  StepReport report = stepper_->step(stepSize(), pins_, loads_->total(), state_);
  if (report.status != StepStatus::kFailed) {
    ++state_.step;
    state_.time = static_cast<double>(state_.step) / scene_.rate;
    loads_->advance();
    if (scene_.effects.plasticity) yield();
    const bool good = stepper_->mayExplode() && stepper_->vouches();
    if (scene_.effects.tearing) report.broken_springs = tear();
    if (good) keep();
  } else {
    if (kept_) goBack();
    report.message += "; the state is that of step " + std::to_string(state_.step);
  }
  totals_.add(report);
  return report;
}

void Simulation::startOver() {
  stepper_->restart();
  kept_.reset();
}

void Simulation::keep() {
  if (!kept_) {
    kept_.emplace();
    kept_->rest_lengths.reserve(rest_lengths_.capacity());
  }
  kept_->state = state_;
  kept_->broken = broken_;
  kept_->rest_lengths = rest_lengths_;
}

void Simulation::goBack() {
  if (broken_ != kept_->broken) breakSprings(kept_->broken);
  rest_lengths_ = kept_->rest_lengths;
  applyRestLengths();
  state_ = kept_->state;
  stepper_->goBack();
}

void Simulation::breakSprings(const std::vector<char>& broken) {
  broken_ = broken;
  take(broken_.empty() ? whole_
                       : std::make_shared<Model>(withoutSprings(scene_, *whole_, broken_)));
}

void Simulation::take(std::shared_ptr<const Model> model) {
  if (model_ && model_->contact) model->contact->continueFrom(*model_->contact);
  auto stepper = std::make_unique<Stepper>(*model, model->solver);
  if (stepper_) stepper->continueFrom(*stepper_);
  stepper_ = std::move(stepper);
  model_ = std::move(model);
}

std::uint32_t Simulation::tear() {
  const std::vector<char> breaking =
      findBreaking(*scene_.effects.tearing, *model_, state_.positions);
  if (breaking.empty()) return 0;
  // The springs of the model are those of the whole that are not broken, in the same order.
  broken_.resize(whole_->springs.size(), 0);
  auto next = breaking.begin();
  for (char& broken : broken_) {
    if (!broken) broken = *next++;
  }
  keepIfNot(breaking, rest_lengths_);
  take(std::make_shared<Model>(withoutSprings(scene_, *model_, breaking)));
  applyRestLengths();
  return static_cast<std::uint32_t>(std::count(breaking.begin(), breaking.end(), 1));
}

void Simulation::yield() {
  if (creep(*scene_.effects.plasticity, stepSize(), model_->springs, state_.positions,
            rest_lengths_)) {
    applyRestLengths();
  }
}

void Simulation::applyRestLengths() {
  if (model_->springs_effect == nullptr) return;
  model_->springs_effect->setRestLengths(model_->springs, rest_lengths_);
}

bool Simulation::timelineDue(double steps) const {
  // 1e-9 of a step: a time that is meant as a step boundary is one.
  return next_timed_command_ < scene_.timeline.size() &&
         scene_.timeline[next_timed_command_].time * scene_.rate <= steps + 1e-9;
}

bool Simulation::continueFrom(const Simulation& other) {
  if (scene_.rate != other.scene_.rate || !samePins(scene_.pins, other.scene_.pins) ||
      !sameObjects(*whole_, *other.whole_)) {
    return false;
  }
  if (broken_ != other.broken_) breakSprings(other.broken_);
  rest_lengths_ = other.rest_lengths_;
  applyRestLengths();
  state_ = other.state_;
  pins_ = other.pins_;
  totals_ = other.totals_;
  *loads_ = *other.loads_;
  if (model_->contact && other.model_->contact) {
    model_->contact->continueFrom(*other.model_->contact);
  }
  startOver();
  timeline_steps_ = other.timeline_steps_;
  for (next_timed_command_ = 0; timelineDue(timeline_steps_);) ++next_timed_command_;
  return true;
}

void Simulation::reset() {
  if (model_ != whole_) take(whole_);
  broken_.clear();
  rest_lengths_.clear();
  applyRestLengths();
  state_ = model_->start;
  totals_ = StepTotals();
  next_timed_command_ = 0;
  timeline_steps_ = -1.0;
  if (model_->contact) model_->contact->reset();
  startOver();
  clearForces();
  restorePins();
}

CommandResult Simulation::setState(const Vectors& positions, const Vectors& velocities) {
  const CommandResult result = checkState(positions, velocities, *model_, pins_, stepSize());
  if (!result.accepted()) return result;
  state_.positions = positions;
  state_.velocities = velocities;
  startOver();
  return {};
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
    command.follow_frame = pin.follow_frame;
    const CommandResult result = applyPin(command);
    if (!result.accepted()) problems.push_back("pins." + pin.name + "." + result.message);
  }
  if (!problems.empty()) throw SceneError(problems);
}

}  // namespace mass_spring
