#include "mass_spring_sim/simulation.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "command_check.h"
#include "effects/plasticity.h"
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
    : Simulation(scene, std::make_shared<const Model>(buildModel(scene))) {}

Simulation::Simulation(Scene scene, std::shared_ptr<const Model> model)
    : scene_(std::move(scene)),
      whole_(std::move(model)),
      state_(whole_->start),
      pins_(whole_->particleCount()),
      loads_(std::make_unique<Loads>(whole_->particleCount())) {
  if (whole_->springs_yield) state_.effects.rest_lengths.reserve(whole_->springs.size());
  take(whole_);
  restorePins();
}

Simulation::~Simulation() = default;

std::uint32_t Simulation::activeForces() const { return loads_->active(); }

std::size_t Simulation::matrixNonzeros() const { return stepper_->matrixNonzeros(); }

Energy Simulation::energy() const { return mass_spring::energy(stepper_->workspace(), state_); }

std::map<std::string, Wrench> Simulation::pinWrenches() const {
  return mass_spring::pinWrenches(stepper_->workspace(), state_, pins_, loads_->total());
}

std::map<std::string, Wrench> Simulation::shapeWrenches() const {
  return mass_spring::shapeWrenches(stepper_->workspace(), state_);
}

std::vector<Touch> Simulation::touches() const {
  return mass_spring::touches(stepper_->workspace(), state_);
}

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
  RigidMotion& motion = state_.effects.shapes[model_->findShape(command.name).value()];
  motion = RigidMotion(motion.at(state_.time), command.target, state_.time,
                       std::max(command.duration, stepSize()));
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
    if (const auto& plasticity = scene_.effects.plasticity) {
      creep(*plasticity, stepSize(), model_->springs, whole_->springs.size(), state_.positions,
            state_.effects.rest_lengths);
    }
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
    kept_->effects.rest_lengths.reserve(state_.effects.rest_lengths.capacity());
  }
  *kept_ = state_;
}

void Simulation::goBack() {
  const bool torn = state_.effects.broken != kept_->effects.broken;
  state_ = *kept_;
  if (torn) fitModel();
  stepper_->goBack();
}

void Simulation::fitModel() {
  const std::vector<char>& broken = state_.effects.broken;
  take(broken.empty() ? whole_ : std::make_shared<Model>(withoutSprings(*whole_, broken)));
}

void Simulation::take(std::shared_ptr<const Model> model) {
  auto stepper = std::make_unique<Stepper>(
      *model, model->solver, stepper_ ? stepper_->workspace().sharedThreads() : nullptr);
  if (stepper_) stepper->continueFrom(*stepper_);
  stepper_ = std::move(stepper);
  model_ = std::move(model);
}

std::uint32_t Simulation::tear() {
  const std::vector<char> breaking =
      findBreaking(*scene_.effects.tearing, *model_, state_.positions);
  if (breaking.empty()) return 0;
  std::vector<char>& broken = state_.effects.broken;
  broken.resize(whole_->springs.size(), 0);
  for (std::size_t s = 0; s < breaking.size(); ++s) {
    if (breaking[s]) broken[model_->springs[s].number] = 1;
  }
  fitModel();
  return static_cast<std::uint32_t>(std::count(breaking.begin(), breaking.end(), 1));
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
  const State& state = other.state_;
  const bool yielded = !state.effects.rest_lengths.empty() && !whole_->springs_yield;
  // Without plasticity, springs keep the lengths to which they have crept.
  if (yielded) whole_ = std::make_shared<Model>(buildModel(scene_, true));
  const bool torn = state_.effects.broken != state.effects.broken;
  std::vector<RigidMotion> shapes = std::move(state_.effects.shapes);
  state_ = state;
  // Shapes go on as those of the other simulation that start where they do, and have their names.
  for (std::size_t s = 0; s < shapes.size(); ++s) {
    const std::vector<Shape>& others = other.whole_->shapes;
    const auto same = std::find(others.begin(), others.end(), whole_->shapes[s]);
    if (same != others.end()) {
      shapes[s] = state.effects.shapes[static_cast<std::size_t>(same - others.begin())];
    }
  }
  state_.effects.shapes = std::move(shapes);
  if (yielded || torn) fitModel();
  pins_ = other.pins_;
  totals_ = other.totals_;
  *loads_ = *other.loads_;
  startOver();
  timeline_steps_ = other.timeline_steps_;
  for (next_timed_command_ = 0; timelineDue(timeline_steps_);) ++next_timed_command_;
  return true;
}

void Simulation::reset() {
  if (model_ != whole_) take(whole_);
  state_ = whole_->start;
  totals_ = StepTotals();
  next_timed_command_ = 0;
  timeline_steps_ = -1.0;
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
