#pragma once

/// Compiles a function twice, for any processor of the architecture and for those with AVX2 and
/// fused multiply-add (x86-64 since 2013); the loader takes the one that fits. On one machine it is
/// always the same one, and so are the results.
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__)
#define MASS_SPRING_DISPATCH __attribute__((target_clones("arch=haswell", "default")))
#else
#define MASS_SPRING_DISPATCH
#endif
