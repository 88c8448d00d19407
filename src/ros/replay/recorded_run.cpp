#include "recorded_run.h"

#include <ros/message_traits.h>
#include <std_msgs/String.h>

#include <set>

#include "ros/topics.h"

namespace mass_spring {

namespace {

using mass_spring_sim::AppliedCommand;
using mass_spring_sim::ParticleStates;

void open(const std::string& file, rosbag::Bag& bag) {
  try {
    bag.open(file, rosbag::bagmode::Read);
  } catch (const rosbag::BagException& error) {
    throw BagError(file + " cannot be read: " + error.what() +
                   ". If it is a recording that was cut off: rosbag reindex " + file);
  }
}

/// The names of the nodes that have told of commands or states.
std::set<std::string> nodesOf(const std::deque<rosbag::Bag>& bags) {
  std::set<std::string> nodes;
  const std::pair<std::string, const char*> kinds[] = {
      {std::string("/") + topics::kApplied, ros::message_traits::DataType<AppliedCommand>::value()},
      {std::string("/") + topics::kState, ros::message_traits::DataType<ParticleStates>::value()}};
  for (const rosbag::Bag& bag : bags) {
    rosbag::View view(bag);
    for (const rosbag::ConnectionInfo* connection : view.getConnections()) {
      const std::string& topic = connection->topic;
      for (const auto& [end, type] : kinds) {
        if (connection->datatype == type && topic.size() > end.size() &&
            topic.compare(topic.size() - end.size(), end.size(), end) == 0) {
          nodes.insert(topic.substr(0, topic.size() - end.size()));
        }
      }
    }
  }
  return nodes;
}

std::string choose(const std::set<std::string>& nodes, const std::string& wanted) {
  std::string known;
  for (const std::string& node : nodes) known += (known.empty() ? "" : ", ") + node;
  if (known.empty()) {
    throw BagError(
        "no node has told of commands or states: expected topics NODE/applied (AppliedCommand) "
        "and NODE/state (ParticleStates)");
  }
  if (wanted.empty() && nodes.size() > 1) {
    throw BagError("several nodes were recorded, choose one by --node: " + known);
  }
  if (!wanted.empty() && nodes.count(wanted) == 0) {
    throw BagError("--node: got " + wanted + ", expected one of those recorded: " + known);
  }
  return wanted.empty() ? *nodes.begin() : wanted;
}

}  // namespace

RecordedRun::RecordedRun(const std::vector<std::string>& files, const std::string& node) {
  for (const std::string& file : files) open(file, bags_.emplace_back());
  node_ = choose(nodesOf(bags_), node);
  const std::string scene = node_ + "/" + topics::kScene;
  const BagTopic<std_msgs::String> scenes(bags_, scene);
  if (scenes.front() == nullptr) {
    throw BagError("there is no " + scene + ": record it, too; a recorder gets it at any time");
  }
  scene_ = scenes.front()->data;
  commands_.emplace(bags_, node_ + "/" + topics::kApplied);
  states_.emplace(bags_, node_ + "/" + topics::kState);
}

void RecordedRun::nextCommand() {
  const std::uint64_t last = command()->number;
  commands_->pop();
  if (command() == nullptr || command()->number == last + 1) return;
  const std::string place = "after command " + std::to_string(last) + " of " + node_ + " comes " +
                            std::to_string(command()->number) + ": ";
  if (command()->number <= last) {
    throw BagError(place +
                   "the node was started anew; record each of its lives in a bag of its own");
  }
  throw BagError(place + "those in between were lost on the way to the recorder");
}

}  // namespace mass_spring
