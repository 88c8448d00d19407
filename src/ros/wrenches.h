#pragma once

#include <geometry_msgs/WrenchStamped.h>
#include <ros/ros.h>

#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace mass_spring {

/// Names of the pins and of the shapes of contact that there are.
struct Names {
  std::vector<std::string> pins, shapes;
};

/// The topics ~wrenches/NAME, one for each pin and each shape. A pin that has the name of a shape
/// has ~wrenches/NAME/pin instead: pins come and go, and a shape keeps its topic. From any thread.
class Wrenches {
 public:
  enum class Of { kPin, kShape };

  /// @param nh             private node handle
  /// @param on_subscriber  called, on a thread of nh's queue, when somebody subscribes to one
  Wrenches(const ros::NodeHandle& nh, std::function<void(Of)> on_subscriber)
      : nh_(nh), on_subscriber_(std::move(on_subscriber)) {}

  /// Offers the topics of these and no others. May wait for the master.
  void offer(const Names& names);

  /// The topics of pins, or of shapes, that have subscribers, by name.
  std::map<std::string, ros::Publisher> heard(Of of) const;

 private:
  struct Offered {
    Of of;
    std::string name;
    ros::Publisher publisher;
  };

  ros::NodeHandle nh_;
  const std::function<void(Of)> on_subscriber_;
  mutable std::mutex mutex_;
  std::map<std::string, Offered> offered_;  ///< by topic
};

}  // namespace mass_spring
