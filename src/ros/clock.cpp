#include "clock.h"

#include <ros/master.h>
#include <ros/this_node.h>

#include <string>
#include <utility>
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

Clock::Clock(ros::NodeHandle& nh, Source source) : source_(source), start_(kFirstValue) {
  if (source_ == Source::kFollowed) {
    ros::NodeHandle own(nh);
    own.setCallbackQueue(&queue_);
    subscriber_ = own.subscribe<rosgraph_msgs::Clock>(
        topics::kClock, 1, [this](const rosgraph_msgs::ClockConstPtr& tick) { follow(*tick); }, {},
        ros::TransportHints().tcpNoDelay());
  }
  if (source_ != Source::kMaster) {
    stamp_ = now();
    return;
  }
  for (const std::string& node : otherClockMasters()) {
    ROS_WARN_STREAM("/use_sim_time is true, so this node publishes "
                    << topics::kClock << ", but " << node
                    << " does so, too: time will jump. Stop it, set ~external_clock to true, or "
                       "/use_sim_time to false.");
  }
  publisher_ = nh.advertise<rosgraph_msgs::Clock>(topics::kClock, 10, true);
  set(start_);
}

Clock::~Clock() { spinner_.stop(); }

void Clock::observe(std::function<void()> observer) {
  observer_ = std::move(observer);
  if (followed()) spinner_.start();
}

void Clock::follow(const rosgraph_msgs::Clock& message) {
  followed_ = static_cast<std::int64_t>(message.clock.toNSec());
  observer_();
}

std::optional<Clock::Pace> Clock::pace() const {
  if (!followed()) return std::chrono::steady_clock::now();
  const std::int64_t nanoseconds = followed_;
  if (nanoseconds == 0) return std::nullopt;
  return Pace(std::chrono::nanoseconds(nanoseconds));
}

void Clock::advance(double sim_time, std::optional<Pace> due) {
  switch (source_) {
    case Source::kWall:
      return set(wallTime());
    case Source::kMaster:
      return set(start_ + ros::Duration(sim_time));
    case Source::kFollowed:
      return set(due ? ros::Time().fromNSec(static_cast<std::uint64_t>(
                           std::chrono::nanoseconds(due->time_since_epoch()).count()))
                     : now());
  }
}

void Clock::restart(double sim_time) {
  if (source_ != Source::kMaster) return set(now());
  const ros::Time last = stamp();
  start_ = last - ros::Duration(sim_time);
  set(last);
}

void Clock::repeat() {
  if (source_ == Source::kMaster &&
      std::chrono::steady_clock::now() - published_ >= kRepeatPeriod) {
    set(stamp());
  }
}

ros::Time Clock::stamp() const {
  std::lock_guard lock(mutex_);
  return stamp_;
}

ros::Time Clock::now() const {
  switch (source_) {
    case Source::kWall:
      return wallTime();
    case Source::kMaster:
      return stamp();
    case Source::kFollowed:
      break;
  }
  return ros::Time().fromNSec(static_cast<std::uint64_t>(followed_.load()));
}

void Clock::set(const ros::Time& stamp) {
  {
    std::lock_guard lock(mutex_);
    stamp_ = stamp;
  }
  if (source_ != Source::kMaster) return;
  rosgraph_msgs::Clock message;
  message.clock = stamp;
  publisher_.publish(message);
  published_ = std::chrono::steady_clock::now();
}

}  // namespace mass_spring
