#include "effects/air_drag.h"

#include "solvers/step_matrix.h"

namespace mass_spring {

AirDrag::AirDrag(double coefficient) : coefficient_(coefficient) {}

std::uint32_t AirDrag::addDerivatives(const Vectors& /*positions*/, const Vectors& /*velocities*/,
                                      const MatrixWeights& weights, Projection /*projection*/,
                                      StepMatrix& matrix) const {
  const SymmetricBlock block = SymmetricBlock::isotropic(weights.damping * coefficient_);
  for (SymmetricBlock& diagonal : matrix.diagonal()) diagonal += block;
  return 0;
}

}  // namespace mass_spring
