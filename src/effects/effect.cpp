#include "effects/effect.h"

namespace mass_spring {

void sumForces(const Model& model, const Vectors* loads, const Vectors& positions,
               const Vectors& velocities, Vectors& forces) {
  forces.setZero();
  for (const auto& effect : model.effects) effect->addForces(positions, velocities, forces);
  if (loads) forces += *loads;
}

}  // namespace mass_spring
