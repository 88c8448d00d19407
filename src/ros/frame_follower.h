#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "frame_motion.h"
#include "frames.h"
#include "mass_spring_sim/simulation.h"

namespace mass_spring {

/// Leads pins and shapes that follow a tf frame to where it is, evenly where it is heard of less
/// often than steps are done. What a lost frame (not known, or not heard of for a second) leads is
/// held where it is. For the thread that steps.
///
/// A pin is made anew when its frame is first found, and then has the frame itself for a target:
/// its particles keep the places in the frame that they have then.
class FrameFollower {
 public:
  explicit FrameFollower(const Frames& frames) : frames_(frames) {}

  /// Commands for what has moved, for the next step.
  std::vector<Command> lead(const Simulation& simulation);

  // Names of what has lost its frame.
  const std::set<std::string>& stalePins() const { return stale_pins_; }
  const std::set<std::string>& staleShapes() const { return stale_shapes_; }

 private:
  /// A pin that has its frame for a target.
  struct Led {
    Pose target;  ///< the last one
    FrameMotion motion;
  };
  /// Where a frame was when it was last heard of.
  struct Heard {
    Pose pose;
    ros::Time stamp;
  };
  void leadShapes(const Simulation& simulation, const ros::Time& now,
                  std::vector<Command>& commands);
  void leadPins(const Simulation& simulation, const ros::Time& now, std::vector<Command>& commands);
  /// What is heard of the frame, unless it is lost; says so when that changes.
  std::optional<Heard> find(const std::string& frame, const char* kind, const std::string& name,
                            const ros::Time& now, std::set<std::string>& stale) const;

  const Frames& frames_;
  std::set<std::string> stale_pins_, stale_shapes_;
  std::map<std::string, Led> led_pins_;
  std::map<std::string, FrameMotion> shape_motions_;
};

}  // namespace mass_spring
