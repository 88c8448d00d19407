#pragma once

#include <memory>

#include "effects/effect.h"
#include "thread_pool.h"

namespace mass_spring {

/// One effect by itself, at a time and with a memory of its own.
class Probe {
 public:
  /// @param effect  that outlives this
  explicit Probe(const Effect& effect, EffectState memory = {}, double at = 0.0)
      : effects(std::move(memory)),
        time(at),
        effect_(effect),
        threads_(std::make_unique<ThreadPool>(1)),
        scratch_(effect.makeScratch(*threads_)) {}

  EffectState effects;
  double time;  // s

  void addEnergy(const Vectors& x, Energy& energy) {
    Sums sums;
    sums.energy = &energy;
    effect_.add(point(x, x), scratch_.get(), sums);
  }
  void addForces(const Vectors& x, const Vectors& v, Vectors& forces) {
    Sums sums;
    sums.forces = &forces;
    effect_.add(point(x, v), scratch_.get(), sums);
  }
  void addForces(const Vectors& x, const Vectors& v, Vectors& forces, Energy& energy,
                 double& dissipation) {
    effect_.add(point(x, v), scratch_.get(), {&forces, &energy, &dissipation, nullptr});
  }
  void addForcesHolding(const Vectors& held, const Vectors& x, const Vectors& v, Vectors& forces,
                        Energy& energy, double& dissipation) {
    effect_.add(point(x, v), scratch_.get(), {&forces, &energy, &dissipation, &held});
  }
  void addForceDerivative(const Vectors& x, const Vectors& v, const Vectors& dx, const Vectors& dv,
                          Vectors& df) {
    effect_.addForceDerivative(point(x, v), scratch_.get(), dx, dv, df);
  }
  std::uint32_t addDerivatives(const Vectors& x, const Vectors& v, const MatrixWeights& weights,
                               Projection projection, StepMatrix& matrix) {
    return effect_.addDerivatives(point(x, v), scratch_.get(), weights, projection, matrix);
  }
  std::uint32_t linearize(const Vectors& x, const Vectors& v, double w, StepMatrix& matrix,
                          Vectors& forces) {
    return effect_.linearize(point(x, v), scratch_.get(), w, matrix, forces);
  }
  double power(const Vectors& x, const Vectors& v) {
    return dynamic_cast<const DrivingEffect&>(effect_).power(point(x, v), scratch_.get());
  }
  bool dependsOnTime(const Vectors& x) {
    return dynamic_cast<const DrivingEffect&>(effect_).dependsOnTime(point(x, x));
  }
  void beginSubstep(const Vectors& x, const Vectors& v, double h) {
    dynamic_cast<const SweptEffect&>(effect_).beginSubstep(*scratch_, x, v, h);
  }

 private:
  Point point(const Vectors& x, const Vectors& v) const { return {x, v, time, effects}; }

  const Effect& effect_;
  std::unique_ptr<ThreadPool> threads_;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace mass_spring
