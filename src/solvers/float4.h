#pragma once

#include <cstring>

namespace mass_spring {

/// Four floats at once: three coordinates, and a fourth that nobody looks at.
using Float4 = float __attribute__((vector_size(16)));

inline __attribute__((always_inline)) Float4 load4(const float* from) {
  Float4 v;
  std::memcpy(&v, from, sizeof v);
  return v;
}
inline __attribute__((always_inline)) void store4(const Float4& v, float* to) {
  std::memcpy(to, &v, sizeof v);
}

/// A symmetric block as its six floats xx xy xz yy yz zz, ready to multiply from the left.
struct Columns4 {
  Float4 x, y, z;  // (xx xy xz *) (xy yy yz *) (xz yz zz *)

  inline __attribute__((always_inline)) explicit Columns4(const float* block) {
    const Float4 low = load4(block);       // xx xy xz yy
    const Float4 high = load4(block + 2);  // xz yy yz zz
    x = low;
    using Indices = int __attribute__((vector_size(16)));
#if defined(__clang__)
    y = __builtin_shufflevector(low, high, 1, 3, 6, 7);
    z = __builtin_shufflevector(high, high, 0, 2, 3, 3);
#else
    y = __builtin_shuffle(low, high, Indices{1, 3, 6, 7});
    z = __builtin_shuffle(high, Indices{0, 2, 3, 3});
#endif
  }
  inline __attribute__((always_inline)) Float4 times(const float* v) const {
    return x * v[0] + y * v[1] + z * v[2];
  }
  inline __attribute__((always_inline)) Float4 times(const Float4& v) const {
    return x * v[0] + y * v[1] + z * v[2];
  }
};

}  // namespace mass_spring
