#pragma once

#include <string>

namespace mass_spring::topics {

// Published, relative to the node's private namespace.
constexpr char kMarkers[] = "markers";
constexpr char kState[] = "state";
constexpr char kTopology[] = "topology";
constexpr char kPoints[] = "points";
constexpr char kPins[] = "pins";
constexpr char kContacts[] = "contacts";
constexpr char kStats[] = "stats";
constexpr char kApplied[] = "applied";
constexpr char kRejected[] = "rejected";
constexpr char kPaused[] = "paused";
constexpr char kScene[] = "scene";
/// Of a pin or a shape.
inline std::string wrench(const std::string& name) { return "wrenches/" + name; }

// Published, global.
constexpr char kClock[] = "/clock";
constexpr char kDiagnostics[] = "/diagnostics";

// Subscribed.
constexpr char kForce[] = "force";
constexpr char kPin[] = "pin";
constexpr char kShape[] = "shape";
inline std::string target(const std::string& pin) { return "pins/" + pin + "/target"; }

// Services.
constexpr char kSetPaused[] = "set_paused";
constexpr char kStep[] = "step";
constexpr char kReset[] = "reset";
constexpr char kReload[] = "reload";
constexpr char kClearForces[] = "clear_forces";
constexpr char kClearPins[] = "clear_pins";
constexpr char kGetState[] = "get_state";
constexpr char kSetState[] = "set_state";

}  // namespace mass_spring::topics
