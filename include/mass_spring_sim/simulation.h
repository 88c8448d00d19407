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
  /// Shares a model with other simulations, which may run on other threads.
  /// @param scene  as above
  /// @param model  built of it, not nullptr
  Simulation(Scene scene, std::shared_ptr<const Model> model);
  ~Simulation();

  const Scene& scene() const { return scene_; }
  /// Valid until springs break, reset() or continueFrom().
  const Model& model() const { return *model_; }
  /// The same model, kept alive by the caller: after tearing, the simulation uses another one.
  std::shared_ptr<const Model> sharedModel() const { return model_; }
  const State& state() const { return state_; }
  const Pins& pins() const { return pins_; }
  const StepTotals& totals() const { return totals_; }
  std::uint32_t activeForces() const;
  double stepSize() const { return 1.0 / scene_.rate; }  ///< s
  std::size_t matrixNonzeros()
      const;  ///< scalars of the whole symmetric step matrix; 0 if explicit

  /// At the present state, by name where there are names; see measures.h. Not while it steps.
  Energy energy() const;
  std::map<std::string, Wrench> pinWrenches() const;
  std::map<std::string, Wrench> shapeWrenches() const;
  std::vector<Touch> touches() const;

  /// Checks a command and, if it is accepted, lets it take effect with the next step.
  CommandResult apply(const Command& command);

  /// The observer is called for each command of the timeline when it is due, with the result.
  using TimelineObserver = std::function<void(const Command&, const CommandResult&)>;
  void observeTimeline(TimelineObserver observer) { timeline_observer_ = std::move(observer); }

  /// Applies the commands of the timeline that are due, then advances by 1 / rate. After a step
  /// that did not fail, springs yield and break if the scene has plasticity or tearing.
  ///
  /// A step that fails leaves the last good state: the state before the step, or with explicit
  /// schemes, which explode over several steps, the last state whose energy was checked and found
  /// good. Positions, velocities, step, time, rest lengths and broken springs go back to it
  /// together. Commands are neither undone nor repeated: pins, forces and shapes are as they were,
  /// and the timeline goes on with the commands that have not been applied.
  StepReport step();

  /// Continues the run of another simulation: takes over its state, broken springs, rest lengths,
  /// pins, forces and totals. From the timeline, only the commands that lie ahead are applied.
  /// Solver, effects and limits stay those of this scene.
  /// @return false, and nothing is done, if the two differ in rate, pins of the scene, particles at
  ///         the start, springs (except stiffness and damping) or triangles
  bool continueFrom(const Simulation& other);

  /// Puts all particles somewhere else [m, m/s; 3 x particles]. Time, springs, pins and forces stay
  /// as they are; the next step takes pinned particles back to their pins. Refused if the size is
  /// wrong, or if a value is not finite or beyond the limits; the message names the first one.
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
  /// Goes on with all springs of the whole model except those that are broken.
  void fitModel();
  /// @return how many springs broke
  std::uint32_t tear();
  /// The state does not follow the last step.
  void startOver();
  /// Keeps the state, so that goBack() can return to it.
  void keep();
  /// Returns to the last state that was kept.
  void goBack();
  /// Is the next command of the timeline due when so many steps are done?
  bool timelineDue(double steps) const;

  Scene scene_;
  std::shared_ptr<const Model> whole_;  // as built of the scene
  std::shared_ptr<const Model> model_;  // the same, or without broken springs
  State state_;
  std::optional<State> kept_;  // to go back to; only with explicit schemes
  Pins pins_;
  StepTotals totals_;
  std::unique_ptr<Loads> loads_;
  std::unique_ptr<Stepper> stepper_;
  std::size_t next_timed_command_ = 0;
  double timeline_steps_ = -1.0;  // commands due after so many steps are applied
  TimelineObserver timeline_observer_;
};

}  // namespace mass_spring
