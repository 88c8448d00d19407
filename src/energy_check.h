#pragma once

#include "effects/effect.h"
#include "schemes/drive.h"

namespace mass_spring {

/// What the effects may feed into the particles at most [W].
double powerOfEffects(Workspace& workspace, const Point& point);

/// What effects that depend on time feed in during a step of h [s] if no particle moves [J].
/// @param start  where the step begins
double fedByTime(Workspace& workspace, const Point& start, double h);

/// The energy that rounding may add or hide.
class RoundingNoise {
 public:
  explicit RoundingNoise(const Model& model);
  /// Rounding of the sums, and of positions, which stiffness and steps turn into energy [J].
  /// @param h    s, the step
  /// @param sum  J, the energies that are added up, all of them taken as positive
  double energy(const Vectors& positions, double h, double sum) const;

 private:
  double stiffness_ = 0.0;  // N/m, sum over springs and effects
  double mass_;             // kg, sum over the particles
};

/// Compares the energy after a step with the energy before it and the work done from outside:
/// forces times displacements, what pins and shapes do by moving, and the wind. Pinned particles
/// have no kinetic energy here, as their motion is prescribed.
class EnergyCheck {
 public:
  /// @param scheme  that makes the steps. xpbd does not follow the energy of the springs: all that
  /// they held at restart(), and all that was lost since, may come back
  EnergyCheck(Workspace& workspace, Scheme scheme);

  /// @param h         s, the step
  /// @param state     before the step, pinned particles with the velocities they will have
  void start(double h, const State& state, const Drive& drive);
  /// Does the state after the step hold more energy than it can have? Over all steps since
  /// restart(), gains may not exceed what was lost before by more than rounding and a small part
  /// of the energies; only the latest losses count. In one step, most schemes may gain no more
  /// than a small part either, which second-order schemes gain and lose in turn.
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
  Energy energyOfFree(const Point& point, const Drive& drive);
  double energyOfIgnored(const Point& point);  ///< J
  /// What the pins do to the particles by moving [W].
  double pinPower(const Point& point, const Drive& drive);

  Workspace& workspace_;
  const RoundingNoise rounding_;
  const Effect* ignored_effect_;  // the effect whose energy the scheme does not follow, or nullptr
  const bool limits_steps_;  // whether there is a limit for each step, besides that for all steps
  const double tolerance_;   // share of the energies that all gains may be above all losses
  bool restarted_ = true;
  double balance_ = 0.0;  // J, gained since restart(); what was dissipated makes it negative
  double earlier_ = 0.0;  // J, as far as it counts for the step checked last
  // J, the largest kinetic and elastic energy, less what was lost since. Where a swing turns round,
  // it has next to none, but the gains and losses of the whole swing are shares of its largest.
  double reference_ = 0.0;
  double gain_ = 0.0, scale_ = 0.0, noise_ = 0.0;  // J, of the step checked last
  double lost_ = 0.0;                              // J, in that step, <= 0
  double kinetic_ = 0.0, moving_ = 0.0;            // J, after it; moving_: kinetic and elastic
  double h_ = 0.0;
  Energy before_;
  double prescribed_motion_work_ =
      0.0;              // J, of pins and shapes if all others stayed where they are
  double power_ = 0.0;  // W, of the pins at the start
  double fed_ = 0.0;    // W, what the effects may feed in at the start
  bool pins_move_ = false;
  std::vector<char> pinned_;  // that the masses belong to
  Vectors free_masses_;
  Vectors start_, scratch_;
};

}  // namespace mass_spring
