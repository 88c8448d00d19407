#pragma once

#include <optional>
#include <vector>

#include "mass_spring_sim/scene.h"
#include "scene/references.h"
#include "scene/tree_reader.h"

namespace mass_spring {

/// The pins of a scene, in bytewise order of their names; they are entered into the ledger.
std::vector<ScenePin> readPins(const Place& place, const ParticleCounts& counts, PinLedger& ledger);

/// The timeline in order of time, checked as far as can be foreseen: also that pins exist when they
/// are moved or removed, and that no particle is held twice.
/// @param ledger  the pins at the start; nothing if they have problems, then what hangs on them is
///                not checked
/// @param shapes  names of the shapes of contact; nullptr if they have problems
std::vector<TimedCommand> readTimeline(const Place& place, const ParticleCounts& counts,
                                       const Limits& limits, std::optional<PinLedger> ledger,
                                       const std::vector<std::string>* shapes);

}  // namespace mass_spring
