#include "frame_follower.h"

#include <ros/console.h>

#include "effects/contact.h"

namespace mass_spring {

namespace {

const ros::Duration kLost(1.0);

}  // namespace

std::vector<ShapeCommand> FrameFollower::lead(const Simulation& simulation) {
  std::vector<ShapeCommand> commands;
  const auto& contact = simulation.scene().effects.contact;
  if (!contact) return commands;
  for (const ContactShape& shape : contact->shapes) {
    if (shape.follow_frame.empty()) continue;
    std::string lost;
    try {
      const Frames::Placed frame = frames_.find(shape.follow_frame);
      const ros::Duration age = ros::Time::now() - frame.stamp;
      if (!frame.stamp.isZero() && age > kLost) {
        lost = "last heard of " + std::to_string(age.toSec()) + " s ago";
      } else {
        const Shape& body = *simulation.model().contact->find(shape.name);
        Pose target;
        target.position = frame.pose * body.start().position;
        target.orientation = Eigen::Quaterniond(frame.pose.linear()) * body.start().orientation;
        const Pose& before = body.motion().target();
        if (target.position != before.position ||
            target.orientation.coeffs() != before.orientation.coeffs()) {
          commands.push_back({shape.name, target, 0.0});
        }
      }
    } catch (const tf2::TransformException& error) {
      lost = error.what();
    }
    if (!lost.empty() && stale_.insert(shape.name).second) {
      ROS_WARN_STREAM("The shape " << shape.name << " stays where it is: its frame "
                                   << shape.follow_frame << " is lost: " << lost);
    } else if (lost.empty() && stale_.erase(shape.name) > 0) {
      ROS_INFO_STREAM("The shape " << shape.name << " follows its frame " << shape.follow_frame
                                   << '.');
    }
  }
  return commands;
}

}  // namespace mass_spring
