#pragma once

#include <vector>

#include "energy_check.h"
#include "schemes/drive.h"

namespace mass_spring {

/// Watches the energy of explicit schemes, which explode where their steps are too large: is there
/// more of it than there was at restart() and than has been given since? The kinetic energy is
/// looked at after each step, which costs next to nothing. All of the energy is compared where that
/// is more than all that moved before, and now and then. Pinned particles have no kinetic energy
/// here, as their motion is prescribed.
class EnergyWatch {
 public:
  /// What one step was like.
  struct Step {
    double h;         ///< s
    double substep;   ///< s
    int evaluations;  ///< of the forces
    double pin_work;  ///< J, what the pins did to the particles by moving
  };

  /// @param scheme  an explicit one
  EnergyWatch(Workspace& workspace, Scheme scheme);

  /// A step has been taken.
  /// @param before, end  the states that it began and ended with
  void observe(const Step& step, const State& before, const State& end, const Drive& drive);
  /// Do the particles have more energy than they can have? One step may end so: the first one after
  /// a force has set in, or a pin, as their work is known a step later with Euler's schemes.
  bool gained() const { return balance_.steps_above >= 2; }
  /// Was all of the energy looked at after the last step, and is it no more than was given?
  bool vouches() const { return vouches_; }
  /// The next step does not follow the last one.
  void restart();
  /// The next step follows the last one that this vouched for, or the first one since restart().
  void goBack();
  /// Goes on from another watch, of a model of the same particles.
  void continueFrom(const EnergyWatch& other);

 private:
  /// What counts from step to step.
  struct Balance {
    bool known = false;    // or the next step is the first
    double given = 0.0;    // J, the energy that the particles may have
    double gravity = 0.0;  // J, the part of it that was gravity's
    double motion = 0.0;   // J, kinetic, elastic, and the changes of gravity's: the latest maximum
    double power = 0.0;    // W, what the effects could feed in at the end of the last step
    int steps_above = 0;   // in a row, up to the last one
    int evaluations = 0;   // of the forces since all of the energy was looked at
    std::vector<char> pinned;  // that this belongs to
  };
  double kineticEnergy(const Vectors& velocities) const;
  Energy energy(const Point& point);
  void begin(const State& before, const Drive& drive);
  void setPinned(const std::vector<char>& pinned);
  void addWork(const Step& step, const State& before, const State& end, const Drive& drive);
  void compare(const Step& step, const State& end, const Drive& drive);

  Workspace& workspace_;
  const RoundingNoise rounding_;
  const double shift_;  // of a sub-step: so much later the velocities are those of the positions
  Balance balance_, vouched_;  // the latter as it was after the last step that this vouched for
  bool vouches_ = false;
  Vectors free_masses_;  // kg per coordinate, 0 for pinned particles
  Vectors velocities_, scratch_;
};

}  // namespace mass_spring
