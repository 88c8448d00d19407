#pragma once

#include <cstdint>
#include <string>

#include "mass_spring_sim/simulation.h"
#include "problems.h"

namespace mass_spring {

/// One run of a hard case, and the fingerprint of all the states it went through.
struct Trial {
  std::string name;  ///< Case.scheme/parameters
  Scheme scheme = Scheme::kImplicitEuler;
  double stiffness = 1.0;  ///< what the stiffnesses of the case are multiplied by
  double h = 1.0 / 60.0;   ///< s, the step
  std::uint64_t fingerprint = 14695981039346656037u;

  double rate() const { return 1.0 / h; }
  /// What the damping is multiplied by, so that the damping ratio stays.
  double damping() const;
  /// Takes bytes into the fingerprint (FNV-1a).
  void add(const void* data, std::size_t size);
};

/// L-stable: what a step is too long for dies out. Only of those it can be asked that stiff scenes
/// come to rest; implicit_midpoint keeps them ringing (numerically undamped, as it should be), and
/// with xpbd they give way as if they were soft.
bool dampsWhatIsStiff(Scheme scheme);

/// How far rounding may carry the center of mass of particles that nothing holds [m]: internal
/// forces of up to k L cancel to 1e-12 of them in each step, the rounding of systems whose
/// condition numbers reach 1e10.
/// @param k_l   N, the strongest spring's stiffness times its strain
/// @param mass  kg, of all particles
double momentumRounding(const Trial& trial, double k_l, double mass, int steps);

/// A net as the trial's scene: its scheme and step; no pins, no gravity.
Scene sceneOf(const Trial& trial, Particles net);
/// An n x n cloth of 1 m and 0.2 kg, level, with the trial's stiffness and damping.
Particles sheet(const Trial& trial, int n);
/// An n x n x n block of 0.3 m and 0.5 kg, with the trial's stiffness and damping.
Particles block(const Trial& trial, int n);
void addGravity(Scene& scene);

/// A simulation in which every step is checked for what has to hold in every case: finite;
/// converged, or degraded and said so; if asked for, no energy from nowhere. The first violation
/// writes the scene to a file, for `simulate`.
class Watched {
 public:
  Watched(Trial& trial, Scene scene);

  Simulation& operator*() { return simulation_; }
  Simulation* operator->() { return &simulation_; }

  /// Explicit schemes may end at a step that is too long for them: they have to say so.
  void mayFail() { may_fail_ = true; }
  /// From now on the energy may not exceed what it is now, by more than a share of itself. The pins
  /// have to stand still. With xpbd, whose springs give way, that is asked of what moves and falls.
  /// @param share  the default is as fine as the engine's check over all steps
  void boundEnergy(double share = 2e-4);

  /// Steps, until a check fails; the report of the last step.
  StepReport step(int steps = 1);
  bool failed() const { return failed_; }
  bool everDegraded() const { return ever_degraded_; }

 private:
  /// @param before  m, the positions before the step
  void check(const StepReport& report, const Vectors& before);
  bool frozen(const StepReport& report, const Vectors& before) const;
  void violation(const std::string& what);
  double energySize() const;

  Trial& trial_;
  Simulation simulation_;
  bool may_fail_ = false, failed_ = false, ever_degraded_ = false;
  bool energy_is_bounded_ = false;
  double energy_bound_ = 0.0;  // J
  double energy_share_ = 0.0;
};

}  // namespace mass_spring
