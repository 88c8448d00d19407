#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mass_spring_sim/command.h"
#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/model.h"
#include "mass_spring_sim/pins.h"
#include "mass_spring_sim/scene.h"
#include "mass_spring_sim/state.h"
#include "mass_spring_sim/step_report.h"

namespace mass_spring {

class Loads;
class Stepper;

/// A scene that runs: model, state, pins, forces and the scheme that advances them.
/// Not thread-safe: one thread steps it and applies commands between steps.
///
///   Simulation simulation(readSceneFile("cloth.yaml"));
///   simulation.apply(PinCommand{...});
///   while (simulation.state().time < 1.0) simulation.step();
class Simulation {
 public:
  /// @throws SceneError if a value of the scene is out of its range
  explicit Simulation(Scene scene);
  ~Simulation();

  const Scene& scene() const { return scene_; }
  /// Until springs break, reset() or continueFrom().
  const Model& model() const { return *model_; }
  /// The same, for as long as it is held: what is torn goes on with another model.
  std::shared_ptr<const Model> sharedModel() const { return model_; }
  const State& state() const { return state_; }
  const Pins& pins() const { return pins_; }
  const StepTotals& totals() const { return totals_; }
  std::uint32_t activeForces() const;
  double stepSize() const { return 1.0 / scene_.rate; }  ///< s
  std::size_t matrixNonzeros()
      const;  ///< scalars of the whole symmetric step matrix; 0 if explicit

  /// By name, at the state; see measures.h. Not while it steps.
  std::map<std::string, Wrench> pinWrenches() const;
  std::map<std::string, Wrench> shapeWrenches() const;
  std::vector<Touch> touches() const;

  /// Checks a command and, if it is accepted, lets it take effect with the next step.
  CommandResult apply(const Command& command);

  /// Called for each command of the timeline when its time has come, with what became of it.
  using TimelineObserver = std::function<void(const Command&, const CommandResult&)>;
  void observeTimeline(TimelineObserver observer) { timeline_observer_ = std::move(observer); }

  /// Applies what the timeline has due, then advances by 1 / rate. After a step that did not fail,
  /// springs yield and break where the scene calls for that.
  ///
  /// A step that fails leaves the last good state: the one before it, or with explicit schemes,
  /// which explode over several steps, the last one whose energy was looked at and was no more than
  /// was given. Positions, velocities, step, time, rest lengths and broken springs go back to it
  /// together. Commands are neither undone nor repeated: pins, forces and shapes are as they were,
  /// and the timeline goes on with what has not been applied.
  StepReport step();

  /// Takes up where another simulation stands: state, broken springs, rest lengths, pins, forces,
  /// totals; of the timeline, what lies ahead. Solver, effects and limits stay those of this scene.
  /// @return false, and nothing is done, if the two differ in rate, pins of the scene, particles at
  ///         the start, springs (but for stiffness and damping) or triangles
  bool continueFrom(const Simulation& other);

  /// Puts all particles somewhere else [m, m/s; 3 x particles]. Time, springs, pins and forces go
  /// on as they are: where a pin holds a particle, the next step takes it there. Refused, naming
  /// the first, if there are more or fewer, or values that are not finite or beyond the limits.
  CommandResult setState(const Vectors& positions, const Vectors& velocities);

  /// Back to the start: state, springs, pins of the scene, timeline; forces cleared, totals zero.
  void reset();
  void clearForces();
  void clearPins();  ///< removes all pins, also those of the scene

 private:
  CommandResult applyForce(const ForceCommand& command);
  CommandResult applyPin(const PinCommand& command);
  CommandResult applyShape(const ShapeCommand& command);
  CommandResult applyClear(const ClearCommand& command);
  void restorePins();
  /// Goes on with a model of the same particles.
  void take(std::shared_ptr<const Model> model);
  /// @return how many springs broke
  std::uint32_t tear();
  void yield();
  /// Those of the springs become rest_lengths_, or as built.
  void applyRestLengths();
  /// The state does not follow the last step.
  void startOver();
  /// The state becomes one to go back to.
  void keep();
  /// To the last state that was kept.
  void goBack();
  /// Goes on with the springs of the whole but these.
  void breakSprings(const std::vector<char>& broken);
  /// Is the next command of the timeline due when so many steps are done?
  bool timelineDue(double steps) const;

  Scene scene_;
  std::shared_ptr<const Model> whole_;  // as built of the scene
  std::shared_ptr<const Model> model_;  // the same, or without what is broken
  std::vector<char> broken_;            // per spring of the whole; empty if none is
  std::vector<double> rest_lengths_;    // m, per spring of the model; empty if as built
  State state_;
  struct Kept {
    State state;
    std::vector<char> broken;
    std::vector<double> rest_lengths;
  };
  std::optional<Kept> kept_;  // to go back to; only with explicit schemes
  Pins pins_;
  StepTotals totals_;
  std::unique_ptr<Loads> loads_;
  std::unique_ptr<Stepper> stepper_;
  std::size_t next_timed_command_ = 0;
  double timeline_steps_ = -1.0;  // what was due after so many steps is applied
  TimelineObserver timeline_observer_;
};

}  // namespace mass_spring
