#pragma once

#include "effects/effect.h"
#include "mass_spring_sim/model.h"
#include "schemes/drive.h"

namespace mass_spring {

/// Compares the energy after a step with the energy before it and the work done from outside:
/// forces times displacements, what pins and shapes do by moving, and the wind. Pinned particles
/// have no kinetic energy here, as their motion is prescribed.
class EnergyCheck {
 public:
  /// @param unheeded  the effect whose energy the scheme does not follow, or nullptr: what it held
  /// at restart(), and all that was lost since, may then come back
  explicit EnergyCheck(const Model& model, const Effect* unheeded = nullptr);

  /// @param h         s, the step
  /// @param state     before the step, pinned particles with the velocities they will have
  void start(double h, const State& state, const Drive& drive);
  /// Does the state after the step hold more energy than it can have? By no more than a small part
  /// in one step, which second-order schemes gain and lose in turn; and by less still over all
  /// steps since restart(), so that small gains do not add up.
  bool gained(const State& end, const Drive& drive);
  /// Where there is no other way: slows the free particles down until the step has gained nothing
  /// at all. @return false if that is not enough
  bool slowDown(State& end, const Drive& drive);
  /// The step that was checked last has been taken.
  void accept();
  void restart();

 private:
  /// kg per coordinate, 0 for pinned particles.
  const Vectors& freeMasses(const Drive& drive);
  Energy energyOfFree(const Vectors& positions, const Vectors& velocities, const Drive& drive);
  double powerOfEffects(const Vectors& positions, const Vectors& velocities) const;
  /// What effects that depend on time would feed in if all particles stayed where they are [J].
  double fedByTime(const Vectors& positions, const Drive& drive) const;
  /// What the pins do to the particles by moving [W].
  double pinPower(const State& state, const Drive& drive);

  const Model& model_;
  const Effect* unheeded_;
  bool restarted_ = true;
  double stiffness_ = 0.0;  // N/m, sum over springs and effects
  double mass_ = 0.0;       // kg, sum over the particles
  double balance_ = 0.0;    // J, gained since restart(); what was dissipated makes it negative
  double gain_ = 0.0, scale_ = 0.0, noise_ = 0.0;  // J, of the step checked last
  double kinetic_ = 0.0;                           // J, after it
  double h_ = 0.0;
  Energy before_;
  double alone_ = 0.0;  // J, what pins and shapes would do if all others stayed where they are
  double power_ = 0.0;  // W, of the pins at the start
  double fed_ = 0.0;    // W, what the effects may feed in at the start
  bool pins_move_ = false;
  std::vector<char> pinned_;  // that the masses belong to
  Vectors free_masses_;
  Vectors start_, scratch_;
};

}  // namespace mass_spring
