#include "schemes/explicit_scheme.h"

#include "effects/effect.h"

namespace mass_spring {

ExplicitScheme::ExplicitScheme(const Model& model, bool symplectic)
    : model_(model), symplectic_(symplectic), forces_(3, model.particleCount()) {}

SubstepReport ExplicitScheme::advance(double h, const Drive& drive, State& state) {
  sumForces(model_, drive.loads, state.positions, state.velocities, forces_);
  for (Eigen::Index i = 0; i < forces_.cols(); ++i) {
    auto x = state.positions.col(i);
    auto v = state.velocities.col(i);
    if (drive.pinned[static_cast<std::size_t>(i)]) {
      v = (drive.pin_positions.col(i) - x) / h;
      x = drive.pin_positions.col(i);
      continue;
    }
    if (!symplectic_) x += h * v;
    v += (h / model_.masses[i]) * forces_.col(i);
    if (symplectic_) x += h * v;
  }
  return {};
}

}  // namespace mass_spring
