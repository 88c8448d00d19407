#pragma once

#include <ros/time.h>

#include "mass_spring_sim/pins.h"

namespace mass_spring {

/// How what follows a tf frame moves with it.
///
/// A frame that is heard of less often than steps are done moves evenly to where it is heard to be,
/// for as long as lies between the last two stamps, so that it arrives when the next one is due.
/// What comes with each step, or after more than 0.2 s, is where it is at once.
///
/// A frame that was lost and is heard of again, or that jumps (faster than 10 m/s or 30 rad/s), is
/// caught up with at 1 m/s and 2 rad/s at the most, and then followed as before. All speeds are
/// those in simulated time.
///
/// A frame that moves by no more than tf's own rounding stands still.
class FrameMotion {
 public:
  struct Speeds {
    double along;  ///< m/s, > 0
    double turn;   ///< rad/s, > 0
  };
  /// Where it is at the end of the step that begins now; once for each step.
  /// @param heard  the newest pose that is known, of that stamp (0 = for ever)
  /// @param now    ascending, in the time of the stamps
  /// @param step   s of simulated time
  /// @param limit  it never goes faster, however slow that is
  Pose follow(const Pose& heard, const ros::Time& stamp, const ros::Time& now, double step,
              const Speeds& limit);
  /// It is lost: it stays where it is, and is caught up with when it is heard of again.
  void lose() { behind_ = true; }

 private:
  /// Evenly to where it is heard to be, however fast.
  Pose evenly(const ros::Time& now) const;

  Pose start_, last_;
  Pose there_;  // where it is heard to be, but for rounding
  ros::Time stamp_, begin_, asked_;
  double duration_ = 0.0;  // s
  bool known_ = false;     // it has been followed before
  bool behind_ = false;    // it is caught up with
};

}  // namespace mass_spring
