#include "effects/air_drag.h"

#include "solvers/step_matrix.h"

namespace mass_spring {

std::uint32_t AirDrag::addDerivatives(const Point& /*point*/, Scratch* /*scratch*/,
                                      const MatrixWeights& weights, Projection /*projection*/,
                                      StepMatrix& matrix) const {
  const SymmetricBlock block = SymmetricBlock::isotropic(weights.damping * coefficient_);
  for (SymmetricBlock& diagonal : matrix.diagonal()) diagonal += block;
  return 0;
}

}  // namespace mass_spring
