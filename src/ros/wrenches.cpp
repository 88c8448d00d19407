#include "wrenches.h"

#include <algorithm>

#include "topics.h"

namespace mass_spring {

namespace {

constexpr std::uint32_t kQueue = 100;

}  // namespace

void Wrenches::offer(const Names& names) {
  std::map<std::string, Offered> wanted;
  for (const std::string& shape : names.shapes) {
    wanted[topics::wrench(shape)] = {Of::kShape, shape, {}};
  }
  for (const std::string& pin : names.pins) {
    const std::string topic = topics::wrench(pin);
    wanted[wanted.count(topic) > 0 ? topic + "/pin" : topic] = {Of::kPin, pin, {}};
  }
  std::map<std::string, Offered> before;
  {
    std::lock_guard lock(mutex_);
    before = offered_;
  }
  for (auto& [topic, offered] : wanted) {
    const auto known = before.find(topic);
    if (known != before.end() && known->second.of == offered.of) {
      offered.publisher = known->second.publisher;
    } else {
      if (known != before.end()) known->second.publisher.shutdown();  // its subscribers come again
      offered.publisher = nh_.advertise<geometry_msgs::WrenchStamped>(
          topic, kQueue,
          [this, of = offered.of](const ros::SingleSubscriberPublisher&) { on_subscriber_(of); });
    }
  }
  std::lock_guard lock(mutex_);
  offered_ = std::move(wanted);
}

std::map<std::string, ros::Publisher> Wrenches::heard(Of of) const {
  std::map<std::string, ros::Publisher> heard;
  std::lock_guard lock(mutex_);
  for (const auto& [topic, offered] : offered_) {
    if (offered.of == of && offered.publisher.getNumSubscribers() > 0) {
      heard.emplace(offered.name, offered.publisher);
    }
  }
  return heard;
}

}  // namespace mass_spring
