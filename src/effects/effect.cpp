#include "effects/effect.h"

namespace mass_spring {

void sumForces(const Model& model, const Vectors* loads, const Vectors& positions,
               const Vectors& velocities, Vectors& forces) {
  forces.setZero();
  for (const auto& effect : model.effects) effect->addForces(positions, velocities, forces);
  if (loads) forces += *loads;
}

void sumForces(const Model& model, const Vectors* loads, const Vectors* held,
               const Vectors& positions, const Vectors& velocities, Vectors& forces, Energy& energy,
               double& dissipation) {
  forces.setZero();
  for (const auto& effect : model.effects) {
    if (held) {
      effect->addForcesHolding(*held, positions, velocities, forces, energy, dissipation);
    } else {
      effect->addForces(positions, velocities, forces, energy, dissipation);
    }
  }
  if (loads) forces += *loads;
}

bool setTime(const Model& model, double time) {
  bool any = false;
  for (const auto& effect : model.effects) any = effect->setTime(time) || any;
  return any;
}

void beginSubstep(const Model& model, const Vectors& positions, const Vectors& velocities,
                  double h) {
  for (const auto& effect : model.effects) effect->beginSubstep(positions, velocities, h);
}

bool endSubstep(const Model& model, const Vectors& positions) {
  bool passed = false;
  for (const auto& effect : model.effects) passed = effect->endSubstep(positions) || passed;
  return passed;
}

}  // namespace mass_spring
