#pragma once

#include <chrono>

namespace mass_spring {

/// s, steady, since some time
inline double wallClock() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace mass_spring
