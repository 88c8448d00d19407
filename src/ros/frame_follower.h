#pragma once

#include <set>
#include <string>
#include <vector>

#include "frames.h"
#include "mass_spring_sim/simulation.h"

namespace mass_spring {

/// Leads shapes that follow a tf frame to where it is. One whose frame is lost (not known, or not
/// heard of for a second) is held where it is. For the thread that steps.
class FrameFollower {
 public:
  explicit FrameFollower(const Frames& frames) : frames_(frames) {}

  /// Commands for the shapes whose frames have moved, for the next step.
  std::vector<ShapeCommand> lead(const Simulation& simulation);
  /// Names of the shapes whose frames are lost.
  const std::set<std::string>& stale() const { return stale_; }

 private:
  const Frames& frames_;
  std::set<std::string> stale_;
};

}  // namespace mass_spring
