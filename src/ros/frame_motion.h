#pragma once

#include <ros/time.h>

#include "mass_spring_sim/pins.h"

namespace mass_spring {

/// How a tf frame moves that is heard of less often than steps are done: evenly to where it is
/// heard to be, for as long as lies between the last two stamps, so that it arrives when the next
/// one is due. What comes with each step, or after more than 0.2 s, is where it is at once.
class FrameMotion {
 public:
  /// Where it is at the end of the step that begins now.
  /// @param heard  the newest pose that is known, of that stamp (0 = for ever)
  /// @param now    ascending, in the time of the stamps; the same again gives the same
  Pose follow(const Pose& heard, const ros::Time& stamp, const ros::Time& now);

 private:
  Pose start_, last_;
  ros::Time stamp_, begin_, asked_;
  double duration_ = 0.0;  // s
};

}  // namespace mass_spring
