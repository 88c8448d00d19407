#pragma once

#include <csignal>

namespace mass_spring {

/// The signal that asked this program to end; 0 = none did.
inline volatile std::sig_atomic_t g_signal = 0;

/// From now on the first SIGINT or SIGTERM is only noted, and the next one ends the program at
/// once.
inline void catchSignals() {
  struct sigaction action {};
  action.sa_handler = [](int signal) { g_signal = signal; };
  action.sa_flags = SA_RESETHAND;
  for (const int signal : {SIGINT, SIGTERM}) sigaction(signal, &action, nullptr);
}

}  // namespace mass_spring
