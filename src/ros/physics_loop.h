#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "clock.h"
#include "command_queue.h"
#include "frame_follower.h"
#include "mass_spring_sim/simulation.h"
#include "publishers.h"
#include "step_meter.h"
#include "throttle.h"

namespace mass_spring {

/// Steps a simulation on a thread of its own, paced by the steady clock (ros::Timer and ros::Rate
/// would wait for the very /clock that the steps make) or by the /clock of others. Between two
/// steps, what other threads have asked for is done in order of arrival, and at once while no step
/// is due. Says on ~applied and ~rejected what became of it.
class PhysicsLoop {
 public:
  PhysicsLoop(std::shared_ptr<Simulation> simulation, Clock& clock, FrameFollower& follower,
              Publishers& publishers);
  /// Waits for the step at hand.
  ~PhysicsLoop();

  void start();
  /// Asks the loop to end. @return false if the step at hand takes longer than patience
  bool stop(std::chrono::milliseconds patience);

  /// @param topic   that the command came on
  /// @param sender  the node that sent it
  /// @return false if too many commands are waiting already
  bool offer(Command command, std::string topic, std::string sender);
  /// Called on the thread that steps with the names of the pins and shapes, when they change.
  void observeNames(std::function<void(Names)> observer);

  // For services; the caller is the node that called them. The future is broken (std::future_error)
  // if the loop ends first.

  struct StepOutcome {
    bool success;
    std::string message;  ///< why not
    std::uint64_t step;   ///< afterwards
    double time;          ///< s, afterwards
  };
  /// Takes steps while paused, unpaced.
  std::future<StepOutcome> step(std::uint32_t steps);
  /// @return whether that was a change
  std::future<bool> setPaused(bool paused);
  std::future<void> reset(std::string caller);
  /// The state as it stands, for a message.
  std::future<mass_spring_sim::ParticleStates> state();
  std::future<CommandResult> setState(Vectors positions, Vectors velocities, std::string caller);
  struct Replacement {
    bool
        continued;  ///< the new simulation goes on where the old one stood, else it is at its start
    /// For the caller to let go of, as it may take longer than a step to free.
    std::shared_ptr<const Simulation> old;
  };
  /// Steps another simulation from now on. Whether that is paused does not change.
  std::future<Replacement> replace(std::shared_ptr<Simulation> simulation, std::string caller);
  /// @return how many there were
  std::future<std::uint32_t> clearForces(std::string caller);
  std::future<std::uint32_t> clearPins(std::string caller);

  /// For a subscriber that has just come: markers at once, other topics if the simulation is
  /// paused.
  void show(Publishers::Topic topic);

 private:
  using Steady = std::chrono::steady_clock;
  struct StepRequest {
    std::uint32_t steps, done;
    std::promise<StepOutcome> outcome;
  };

  template <class Function>
  auto ask(Function function) -> std::future<decltype(function())>;
  void run();
  void take(std::shared_ptr<Simulation> simulation);
  /// Says what became of a command.
  void tell(const std::string& topic, const std::string& sender, const Command& command,
            const CommandResult& result);
  /// Says that something was done that acts on the next step.
  void tellApplied(const std::string& sender, mass_spring_sim::AppliedCommand message);
  void tellApplied(const std::string& sender, std::uint8_t kind);
  void tellNames();
  /// Simulated time begins anew.
  void startOver();
  bool stepDue();
  void advance();
  /// From now on in step with the clock.
  void synchronize();
  void changePaused(bool paused);
  void finishRequest(bool success, const std::string& message);

  Clock& clock_;
  FrameFollower& follower_;
  Publishers& publishers_;
  CommandQueue queue_;

  // Of the thread that steps.
  std::shared_ptr<Simulation> simulation_;
  Steady::duration period_;  ///< of the clock that paces, per step; 0 = not paced
  bool paused_;
  bool redraw_ = false;  ///< what viewers see is out of date
  bool obeyed_ = false;  ///< a command has changed pins or shapes since they were told
  std::optional<StepRequest> request_;
  Names names_;  ///< as the observer knows them
  std::function<void(Names)> name_observer_;
  Clock::Pace deadline_;  ///< of the next step
  StepMeter meter_;
  std::uint64_t overruns_ = 0;
  Throttle degraded_throttle_, broken_throttle_;

  std::thread thread_;
  std::promise<void> ended_promise_;
  std::future<void> ended_;
};

}  // namespace mass_spring
