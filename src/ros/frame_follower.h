#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "frame_motion.h"
#include "frames.h"
#include "mass_spring_sim/shape.h"
#include "mass_spring_sim/simulation.h"

namespace mass_spring {

/// Leads pins and shapes that follow a tf frame to where it is, as FrameMotion has it. What a lost
/// frame (not known, or not heard of for a second) leads is held where it is. A frame that has
/// never been heard of is lost only after a second of wall time. For the thread that steps.
///
/// A pin is made anew when its frame is first found, and then has the frame itself for a target:
/// its particles keep the places in the frame that they have then. A shape is put where its frame
/// has it, within a step unless that is too far for limits.max_speed.
class FrameFollower {
 public:
  explicit FrameFollower(const Frames& frames) : frames_(frames) {}

  /// Commands for what has moved, for the next step; none is too fast for limits.max_speed.
  std::vector<Command> lead(const Simulation& simulation);

  // Names of what has lost its frame.
  const std::set<std::string>& stalePins() const { return stale_pins_; }
  const std::set<std::string>& staleShapes() const { return stale_shapes_; }

  // Is it where its frame has it, or had it when that was last heard of?
  bool leads(const std::string& name, const Pin& pin) const;
  bool leads(const Shape& shape, const RigidMotion& motion) const;

 private:
  using Steady = std::chrono::steady_clock;
  /// What is known of a frame in this step.
  struct Place {
    std::optional<Pose> pose;
    bool awaited = false;  ///< not known yet, and not lost yet either
    std::string problem;   ///< why there is no pose
  };

  void leadShapes(const Simulation& simulation, std::vector<Command>& commands);
  void leadPins(const Simulation& simulation, std::vector<Command>& commands);
  /// Where the frame is, unless it is lost; says so when that changes.
  std::optional<Pose> find(const std::string& frame, const char* kind, const std::string& name,
                           const Simulation& simulation, std::set<std::string>& stale);
  /// How far from the frame's origin the particles of pins are that follow it [m], > 0.
  double reach(const std::string& frame, const Simulation& simulation) const;
  Place look(const std::string& frame, const Simulation& simulation);

  const Frames& frames_;
  std::set<std::string> stale_pins_, stale_shapes_;
  std::map<std::string, Place> places_;                ///< of frames, in this step
  std::map<std::string, FrameMotion> motions_;         ///< of frames: what follows one moves as one
  std::map<std::string, Steady::time_point> awaited_;  ///< frames, since when
  // Of what has its frame for a target: the last one.
  std::map<std::string, Pose> led_pins_, led_shapes_;
};

}  // namespace mass_spring
