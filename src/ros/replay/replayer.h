#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mass_spring_sim/simulation.h"
#include "recorded_run.h"
#include "recorded_timeline.h"

namespace mass_spring {

/// Where a recorded state and the simulated one are not the same, bit for bit.
struct Difference {
  std::uint64_t step;
  std::string object;
  std::uint32_t particle;  ///< of the object
  bool velocity;           ///< in m/s; else a position in m
  Eigen::Vector3d recorded, simulated;
  double distance() const { return (recorded - simulated).norm(); }
};

struct Comparison {
  std::uint64_t commands = 0, states = 0, differing_states = 0, restarts = 0;
  std::uint64_t missed_commands = 0;  ///< before the recording; compared from the first reset on
  std::optional<Difference> first;    ///< of the first state that differs
  std::optional<Difference> largest;  ///< of all positions
  std::vector<std::string> refused;   ///< other ways in which the runs differ
  bool budget = false;                ///< the speed of the machine has a say
  bool same() const { return differing_states == 0 && refused.empty(); }
};

/// Does a recorded run again: the same commands before the same steps.
class Replayer {
 public:
  explicit Replayer(RecordedRun& run) : run_(run) {}

  /// To the end of the recording, or to where the runs part for good.
  /// @throws BagError    if the recording does not tell all of the run
  /// @throws SceneError  if this version of the package refuses its scene
  void run();

  const Comparison& comparison() const { return comparison_; }
  /// At the end of the recording.
  const Simulation& simulation() const { return *simulation_; }
  /// Since the last reset.
  const RecordedTimeline& timeline() const { return timeline_; }

 private:
  using Applied = mass_spring_sim::AppliedCommand;

  void follow(const Applied& command);
  void apply(const Applied& command);
  void reload(const Applied& command);
  void take(std::unique_ptr<Simulation> simulation);
  void startOver();
  void checkFirst(const Applied& command, bool starts_over);

  /// @param limit  the command before which this is to be; nullptr = none
  void passStates(const Applied* limit);
  void advanceTo(std::uint64_t step, const Applied* limit);
  void compareHere(const Applied* limit);
  /// @throws BagError if the state was told after commands that the bag does not have
  void checkCommands(const mass_spring_sim::ParticleStates& state) const;
  void compare(const mass_spring_sim::ParticleStates& recorded);
  void compare(const std::vector<double>& recorded, const Vectors& simulated, bool velocity,
               std::optional<Difference>& first);
  /// Takes a step and compares what the scene's timeline did in it with what was told of that.
  StepReport step();
  /// The timeline acts in a step. Where a run ends with that, no state tells of the step.
  void finishTold();
  /// The next step fails, as it did for the node.
  void fail(const Applied& command);
  std::string nextStep() const;

  RecordedRun& run_;
  std::unique_ptr<Simulation> simulation_;
  RecordedTimeline timeline_;
  Comparison comparison_;
  bool first_ = true;                        ///< no command has been met yet
  std::uint64_t done_ = 0;                   ///< commands of the node that are done, or follow next
  std::uint64_t failed_ = 0;                 ///< the step that failed last; 0 = none so far
  std::vector<Applied> told_, own_applied_;  ///< by the scene's timeline, before the next step
};

}  // namespace mass_spring
