#pragma once

extern "C" void __asan_init() __attribute__((weak));

namespace mass_spring {

/// Is the library that is tested one with sanitizers? The tests themselves are the same either way.
/// It runs ten times slower: where fewer or shorter runs execute the same code, they do.
inline bool underSanitizers() { return __asan_init != nullptr; }

}  // namespace mass_spring
