#pragma once

namespace mass_spring::topics {

// Published, relative to the node's private namespace.
constexpr char kMarkers[] = "markers";
constexpr char kState[] = "state";
constexpr char kTopology[] = "topology";
constexpr char kPins[] = "pins";
constexpr char kContacts[] = "contacts";
constexpr char kStats[] = "stats";
constexpr char kApplied[] = "applied";
constexpr char kRejected[] = "rejected";
constexpr char kPaused[] = "paused";
constexpr char kScene[] = "scene";

// Published, global.
constexpr char kClock[] = "/clock";

// Subscribed.
constexpr char kForce[] = "force";
constexpr char kPin[] = "pin";
constexpr char kShape[] = "shape";

// Services.
constexpr char kSetPaused[] = "set_paused";
constexpr char kStep[] = "step";
constexpr char kReset[] = "reset";
constexpr char kReload[] = "reload";
constexpr char kClearForces[] = "clear_forces";
constexpr char kClearPins[] = "clear_pins";

}  // namespace mass_spring::topics
