#pragma once

#include <mass_spring_sim/AppliedCommand.h>
#include <mass_spring_sim/ParticleStates.h>

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "bag_topic.h"

namespace mass_spring {

/// What a node has told of a run: its scene, the commands that it applied and its states.
class RecordedRun {
 public:
  /// @param files  one bag, or those into which `rosbag record --split` has divided it
  /// @param node   name of the node; "" = the only one in the bags
  /// @throws BagError if a file is no bag that can be read, or does not tell of such a node
  RecordedRun(const std::vector<std::string>& files, const std::string& node);

  const std::string& node() const { return node_; }
  /// The one that the recording began with, resolved, as YAML.
  const std::string& scene() const { return scene_; }

  /// The next command; nullptr after the last.
  const mass_spring_sim::AppliedCommand* command() const { return commands_->front(); }
  /// @throws BagError if some are missing in between
  void nextCommand();
  /// The next state; nullptr after the last.
  const mass_spring_sim::ParticleStates* state() const { return states_->front(); }
  void nextState() { states_->pop(); }

 private:
  std::deque<rosbag::Bag> bags_;
  std::string node_, scene_;
  std::optional<BagTopic<mass_spring_sim::AppliedCommand>> commands_;
  std::optional<BagTopic<mass_spring_sim::ParticleStates>> states_;
};

}  // namespace mass_spring
