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
  void leadShapes(const Simulation& simulation, const ros::Time& now,
                  std::vector<Command>& commands);
  void leadPins(const Simulation& simulation, const ros::Time& now, std::vector<Command>& commands);
  /// Where the frame is, unless it is lost; says so when that changes.
  std::optional<Pose> find(const std::string& frame, const char* kind, const std::string& name,
                           const ros::Time& now, std::set<std::string>& stale);

  const Frames& frames_;
  std::set<std::string> stale_pins_, stale_shapes_;
  std::map<std::string, FrameMotion> motions_;  ///< of frames: what follows one moves as one
  std::map<std::string, Pose> led_;  ///< of pins that have their frame for a target: the last one
};

}  // namespace mass_spring
