#pragma once

#include "mass_spring_sim/model.h"
#include "schemes/drive.h"

namespace mass_spring {

/// One force evaluation a step: explicit Euler (course notes eq. 10-11) moves with the old
/// velocities, symplectic Euler with the new ones.
class ExplicitScheme {
 public:
  ExplicitScheme(const Model& model, bool symplectic);
  /// Advances positions and velocities by h [s].
  SubstepReport advance(double h, const Drive& drive, State& state);

 private:
  const Model& model_;
  bool symplectic_;
  Vectors forces_;
};

}  // namespace mass_spring
