// Lets the mouse drag particles in RViz: with the tool Interact, take hold of an object anywhere.
//
//   roslaunch mass_spring_sim simulate.launch scene:=cloth drag:=true
//
// The particle nearest to where the mouse takes hold is pinned, follows the mouse in the plane of
// the screen (with Shift: towards and away from the viewer), and is let go with the mouse button.
// A particle that a pin holds already stays with that.
//
// Parameters (private)
//   node     name of the simulation's node                                        mass_spring
//   rate     Hz of wall time: how often what the mouse can take hold of follows   5.0
//   size     m: of it, around each particle; 0 = twice the distance of neighbors 0.0
//   opacity  of it                                                                0.02

#include <interactive_markers/interactive_marker_server.h>
#include <mass_spring_sim/GetState.h>
#include <mass_spring_sim/PinCommand.h>
#include <mass_spring_sim/RejectedCommand.h>
#include <mass_spring_sim/Topology.h>
#include <ros/ros.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "topics.h"

namespace {

using namespace mass_spring;
using Feedback = visualization_msgs::InteractiveMarkerFeedback;
using mass_spring_sim::ParticleStates;
using mass_spring_sim::PinCommand;
using mass_spring_sim::Topology;
using visualization_msgs::Marker;

// RViz says all 0.25 s that the mouse is still held. Whoever does not has gone.
const ros::WallDuration kPatience(2.0);

Eigen::Vector3d toEigen(const geometry_msgs::Point& p) { return {p.x, p.y, p.z}; }

geometry_msgs::Point toPoint(const Eigen::Vector3d& p) {
  geometry_msgs::Point point;
  point.x = p.x();
  point.y = p.y();
  point.z = p.z();
  return point;
}

struct Object {
  std::string name;
  std::size_t first, count;   ///< particles
  double spacing;             ///< m
  std::vector<double> drawn;  ///< m: x0 y0 z0 ... when its marker was last sent; empty = not since
};

/// Mean rest length of the structural springs of each object; 0.1 m where there are none.
std::vector<Object> objectsOf(const Topology& topology) {
  std::vector<Object> objects;
  for (std::size_t o = 0; o < topology.objects.size(); ++o) {
    objects.push_back(
        {topology.objects[o], topology.first_particle[o], topology.particle_count[o], 0.0, {}});
  }
  std::vector<std::size_t> counts(objects.size());
  for (std::size_t s = 0; s < topology.spring_kind.size(); ++s) {
    if (topology.spring_kind[s] != Topology::STRUCTURAL || topology.rest_lengths[s] <= 0.0)
      continue;
    const auto next = std::upper_bound(topology.first_particle.begin(),
                                       topology.first_particle.end(), topology.springs[2 * s]);
    const std::size_t o = next - topology.first_particle.begin() - 1;
    objects[o].spacing += topology.rest_lengths[s];
    ++counts[o];
  }
  for (std::size_t o = 0; o < objects.size(); ++o) {
    objects[o].spacing = counts[o] > 0 ? objects[o].spacing / counts[o] : 0.1;
  }
  return objects;
}

class DragMarkers {
 public:
  explicit DragMarkers(ros::NodeHandle& nh)
      : nh_(nh),
        node_(ros::names::resolve(nh.param<std::string>("node", "mass_spring"))),
        size_(nh.param("size", 0.0)),
        opacity_(nh.param("opacity", 0.02)),
        server_(ros::this_node::getName()) {
    const double rate = nh.param("rate", 5.0);
    if (!(rate > 0.0) || !(size_ >= 0.0) || !(opacity_ >= 0.0 && opacity_ <= 1.0)) {
      throw std::runtime_error("expected rate > 0, size >= 0, opacity in [0, 1]");
    }
    pins_ = nh.advertise<PinCommand>(name(topics::kPin), 1000);
    topology_ = nh.subscribe(name(topics::kTopology), 10, &DragMarkers::rebuild, this);
    rejected_ = nh.subscribe(name(topics::kRejected), 1000, &DragMarkers::refused, this);
    timer_ = nh.createWallTimer(ros::WallDuration(1.0 / rate),
                                [this](const ros::WallTimerEvent&) { follow(); });
  }

 private:
  struct Drag {
    std::string object, pin;
    Eigen::Vector3d offset;  ///< m, from the marker to the particle
    ros::WallTime heard_of;
  };

  std::string name(const char* topic) const { return node_ + "/" + topic; }

  void rebuild(const Topology& topology) {
    for (const Object& object : objects_) server_.erase(object.name);
    objects_ = objectsOf(topology);
    follow();
  }

  /// Asks for the state, which a paused simulation tells, too.
  /// @return whether state_ is a state of objects_
  bool look() {
    // Whom nobody hears yet, or answers, offers nothing.
    if (pins_.getNumSubscribers() == 0 || rejected_.getNumPublishers() == 0) return false;
    if (!get_state_.isValid()) {
      get_state_ = nh_.serviceClient<mass_spring_sim::GetState>(name(topics::kGetState), true);
    }
    mass_spring_sim::GetState call;
    if (!get_state_.call(call) || !call.response.success) return false;
    state_ = std::move(call.response.state);
    // The topology of another scene may be on its way.
    return !objects_.empty() &&
           state_.positions.size() == 3 * (objects_.back().first + objects_.back().count);
  }

  Eigen::Vector3d place(std::size_t particle) const {
    return Eigen::Map<const Eigen::Vector3d>(&state_.positions[3 * particle]);
  }

  /// Sends markers of what has moved.
  void follow() {
    if (drag_ && ros::WallTime::now() - drag_->heard_of > kPatience) {
      ROS_WARN("Nothing heard of the mouse for %g s: %s is let go.", kPatience.toSec(),
               drag_->object.c_str());
      letGo();
    }
    if (!look()) return;
    for (Object& object : objects_) {
      if (drag_ && drag_->object == object.name) continue;
      const auto begin = state_.positions.begin() + 3 * object.first;
      const auto end = begin + 3 * object.count;
      const auto near = [&](double a, double b) { return std::abs(a - b) < 0.1 * object.spacing; };
      if (std::equal(begin, end, object.drawn.begin(), object.drawn.end(), near)) continue;
      object.drawn.assign(begin, end);
      std::vector<geometry_msgs::Point> points;
      for (std::size_t p = object.first; p < object.first + object.count; ++p) {
        points.push_back(toPoint(place(p)));
      }
      send(object, std::move(points), opacity_);
    }
    server_.applyChanges();
  }

  void send(const Object& object, std::vector<geometry_msgs::Point> points, double opacity) {
    visualization_msgs::InteractiveMarker marker;
    marker.header.frame_id = state_.header.frame_id;
    marker.name = object.name;
    marker.pose.orientation.w = 1.0;
    marker.scale = 1.0;
    visualization_msgs::InteractiveMarkerControl control;
    control.name = "drag";
    control.interaction_mode = visualization_msgs::InteractiveMarkerControl::MOVE_3D;
    control.orientation.w = 1.0;
    control.always_visible = true;
    Marker shape;
    shape.type = Marker::SPHERE_LIST;
    shape.pose.orientation.w = 1.0;
    shape.scale.x = shape.scale.y = shape.scale.z = size_ > 0.0 ? size_ : 2.0 * object.spacing;
    shape.color.r = shape.color.g = shape.color.b = 1.0f;
    shape.color.a = static_cast<float>(opacity);
    shape.points = std::move(points);
    control.markers.push_back(std::move(shape));
    marker.controls.push_back(std::move(control));
    server_.insert(marker, [this](const visualization_msgs::InteractiveMarkerFeedbackConstPtr& f) {
      feel(*f);
    });
  }

  /// What the mouse does.
  void feel(const Feedback& feedback) {
    if (feedback.event_type == Feedback::MOUSE_DOWN) {
      takeHold(feedback);
    } else if (drag_ && drag_->object == feedback.marker_name) {
      drag_->heard_of = ros::WallTime::now();
      if (feedback.event_type == Feedback::POSE_UPDATE) {
        PinCommand command;
        command.action = PinCommand::MOVE;
        command.name = drag_->pin;
        command.header.frame_id = feedback.header.frame_id;
        command.target.position = toPoint(toEigen(feedback.pose.position) + drag_->offset);
        pins_.publish(command);
      } else if (feedback.event_type == Feedback::MOUSE_UP) {
        letGo();
      }
    }
  }

  void takeHold(const Feedback& feedback) {
    letGo();
    const auto object = std::find_if(objects_.begin(), objects_.end(), [&](const Object& known) {
      return known.name == feedback.marker_name;
    });
    if (!look() || object == objects_.end()) return;
    const Eigen::Vector3d marker = toEigen(feedback.pose.position);
    const Eigen::Vector3d mouse =
        feedback.mouse_point_valid ? toEigen(feedback.mouse_point) : marker;
    std::size_t nearest = object->first;
    for (std::size_t p = object->first; p < object->first + object->count; ++p) {
      if ((place(p) - mouse).norm() < (place(nearest) - mouse).norm()) nearest = p;
    }
    PinCommand command;
    command.action = PinCommand::ADD;
    command.name = "drag_" + object->name;
    command.object = object->name;
    command.particles = {static_cast<std::uint32_t>(nearest - object->first)};
    command.here = true;
    pins_.publish(command);
    drag_ = Drag{object->name, command.name, place(nearest) - marker, ros::WallTime::now()};
    // In place of all particles, the mouse takes one along.
    send(*object, {toPoint(drag_->offset)}, 1.0);
    server_.applyChanges();
  }

  void letGo() {
    if (!drag_) return;
    PinCommand command;
    command.action = PinCommand::REMOVE;
    command.name = drag_->pin;
    pins_.publish(command);
    end();
  }

  void end() {
    for (Object& object : objects_) {
      if (object.name == drag_->object) object.drawn.clear();
    }
    drag_.reset();
  }

  void refused(const mass_spring_sim::RejectedCommand& rejected) {
    if (rejected.sender != ros::this_node::getName() || !drag_) return;
    ROS_WARN("%s is not dragged: %s", drag_->object.c_str(), rejected.message.c_str());
    end();
  }

  ros::NodeHandle nh_;
  const std::string node_;
  const double size_, opacity_;
  interactive_markers::InteractiveMarkerServer server_;
  ros::Publisher pins_;
  ros::Subscriber topology_, rejected_;
  ros::ServiceClient get_state_;
  ros::WallTimer timer_;
  std::vector<Object> objects_;
  ParticleStates state_;
  std::optional<Drag> drag_;
};

}  // namespace

int main(int argc, char** argv) {
  // Each line appears when it is written, in a pipe, too.
  std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);
  // The mouse lives in wall time, also while the simulation is paused. In simulated time, the
  // server would take all of it for a quarrel of two clients within a second.
  std::vector<char*> arguments(argv, argv + argc);
  std::string wall_time = "/use_sim_time:=/drag_markers/use_sim_time";
  arguments.push_back(wall_time.data());
  argc = static_cast<int>(arguments.size());
  arguments.push_back(nullptr);
  ros::init(argc, arguments.data(), "drag_markers");
  ros::NodeHandle nh("~");
  try {
    const DragMarkers markers(nh);
    ros::spin();
  } catch (const std::runtime_error& error) {
    ROS_FATAL("%s", error.what());
    return 1;
  }
}
