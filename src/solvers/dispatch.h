#pragma once

/// Compiles a function for any processor of the architecture, for those with AVX2 (and, as of GCC
/// 12, fused multiply-add: x86-64-v3, since 2013) and for those with AVX-512 (x86-64-v4); the
/// loader takes the one that fits. On one machine it is always the same one, and so are the
/// results. Named by what they need: a clone for `arch=haswell` would run on a Haswell and no
/// later processor.
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#if __GNUC__ >= 12
#define MASS_SPRING_DISPATCH \
  __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define MASS_SPRING_DISPATCH __attribute__((target_clones("avx2", "default")))
#endif
#else
#define MASS_SPRING_DISPATCH
#endif
