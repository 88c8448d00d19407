#pragma once

#include <optional>
#include <vector>

#include "mass_spring_sim/scene.h"
#include "mass_spring_sim/state.h"

namespace mass_spring {

/// The exact states at some times [s], for scenes whose particles are each on their own: pinned,
/// falling freely, or on one spring to a pinned particle along which everything acts that acts on
/// it: m l'' = -k (l - L) - c l' + m g, which is linear as long as the spring is not turned inside
/// out. Nothing for all other scenes, and for those with a timeline.
std::optional<std::vector<State>> closedForm(const Scene& scene, const std::vector<double>& times);

}  // namespace mass_spring
