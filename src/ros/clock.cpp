#include "clock.h"

#include <ros/master.h>
#include <ros/this_node.h>
#include <rosgraph_msgs/Clock.h>

#include <string>
#include <vector>

#include "topics.h"

namespace mass_spring {

namespace {

constexpr std::chrono::milliseconds kRepeatPeriod(100);

// roscpp takes a clock of 0 for "no clock yet"; the smallest step above it keeps stamps readable.
const ros::Time kFirstValue(0, 1);

ros::Time wallTime() {
  const ros::WallTime now = ros::WallTime::now();
  return {now.sec, now.nsec};
}

/// Other nodes that publish /clock, as the master knows them.
std::vector<std::string> otherClockMasters() {
  std::vector<std::string> others;
  XmlRpc::XmlRpcValue request, response, payload;
  request[0] = ros::this_node::getName();
  if (!ros::master::execute("getSystemState", request, response, payload, false)) return others;
  XmlRpc::XmlRpcValue& published = payload[0];
  for (int i = 0; i < published.size(); ++i) {
    if (static_cast<std::string&>(published[i][0]) != topics::kClock) continue;
    XmlRpc::XmlRpcValue& nodes = published[i][1];
    for (int k = 0; k < nodes.size(); ++k) {
      const std::string& node = static_cast<std::string&>(nodes[k]);
      if (node != ros::this_node::getName()) others.push_back(node);
    }
  }
  return others;
}

}  // namespace

Clock::Clock(ros::NodeHandle& nh, bool master) : master_(master), start_(kFirstValue) {
  if (!master_) {
    stamp_ = wallTime();
    return;
  }
  for (const std::string& node : otherClockMasters()) {
    ROS_WARN_STREAM("/use_sim_time is true, so this node publishes "
                    << topics::kClock << ", but " << node
                    << " does so, too: time will jump. Stop it, or set /use_sim_time to false.");
  }
  publisher_ = nh.advertise<rosgraph_msgs::Clock>(topics::kClock, 10, true);
  set(start_);
}

void Clock::advance(double sim_time) {
  set(master_ ? start_ + ros::Duration(sim_time) : wallTime());
}

void Clock::restart() {
  start_ = stamp();
  set(master_ ? start_ : wallTime());
}

void Clock::repeat() {
  if (master_ && std::chrono::steady_clock::now() - published_ >= kRepeatPeriod) set(stamp());
}

ros::Time Clock::stamp() const {
  std::lock_guard lock(mutex_);
  return stamp_;
}

ros::Time Clock::now() const { return master_ ? stamp() : wallTime(); }

void Clock::set(const ros::Time& stamp) {
  {
    std::lock_guard lock(mutex_);
    stamp_ = stamp;
  }
  if (!master_) return;
  rosgraph_msgs::Clock message;
  message.clock = stamp;
  publisher_.publish(message);
  published_ = std::chrono::steady_clock::now();
}

}  // namespace mass_spring
