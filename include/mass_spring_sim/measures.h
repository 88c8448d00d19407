#pragma once

#include <optional>

#include "mass_spring_sim/model.h"
#include "mass_spring_sim/state.h"

namespace mass_spring {

struct Energy {
  double kinetic = 0.0;  ///< J
  double elastic = 0.0;  ///< J, springs (course notes eq. 5)
  double gravity = 0.0;  ///< J, 0 at the origin of the scene's frame
  double total() const { return kinetic + elastic + gravity; }
};

Energy energy(const Model& model, const State& state);

/// m/s
double maxSpeed(const State& state);

/// Largest length / rest length over the springs with a rest length above 0; 0 if there are none.
double maxStretch(const Model& model, const State& state);

/// Strain l / L - 1 of one spring; 0 where L = 0.
double strain(const Spring& spring, const Vectors& positions);

/// The first particle whose position or velocity is not finite.
std::optional<std::uint32_t> firstNotFinite(const State& state);

}  // namespace mass_spring
