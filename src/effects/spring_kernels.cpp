#include "effects/spring_kernels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "solvers/dispatch.h"

// Inlined, so as to be compiled with each clone of what calls it. Before a loop: what it writes, it
// reads nowhere else.
#if defined(__clang__)
#define MASS_SPRING_INLINE inline __attribute__((always_inline))
#define MASS_SPRING_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#elif defined(__GNUC__)
#define MASS_SPRING_INLINE inline __attribute__((always_inline))
#define MASS_SPRING_INDEPENDENT _Pragma("GCC ivdep")
#else
#define MASS_SPRING_INLINE inline
#define MASS_SPRING_INDEPENDENT
#endif

namespace mass_spring {
namespace {

/// A value of each spring, in memory or one for all.
template <bool uniform>
struct Value {
  const double* values;
  double first;
  MASS_SPRING_INLINE explicit Value(const double* v) : values(v), first(uniform ? *v : 0.0) {}
  MASS_SPRING_INLINE double operator[](std::uint32_t s) const {
    return uniform ? first : values[s];
  }
};

/// Differences of the ends' coordinates.
struct Difference {
  const double *xi, *yi, *zi;
  const double *xj, *yj, *zj;
  MASS_SPRING_INLINE Difference(const EndColumns& i, const EndColumns& j)
      : xi(i.x), yi(i.y), zi(i.z), xj(j.x), yj(j.y), zj(j.z) {}
  MASS_SPRING_INLINE double x(std::uint32_t s) const { return xj[s] - xi[s]; }
  MASS_SPRING_INLINE double y(std::uint32_t s) const { return yj[s] - yi[s]; }
  MASS_SPRING_INLINE double z(std::uint32_t s) const { return zj[s] - zi[s]; }
};

/// SpringDirection without a branch.
struct Direction {
  double length, inverse, x, y, z;  // inverse 0 where the ends coincide
  MASS_SPRING_INLINE Direction(const Difference& d, std::uint32_t s) {
    const double dx = d.x(s), dy = d.y(s), dz = d.z(s);
    length = std::sqrt(dx * dx + dy * dy + dz * dz);
    const double reciprocal = 1.0 / length;
    inverse = length != 0.0 ? reciprocal : 0.0;
    x = dx * inverse;
    y = dy * inverse;
    const double along_z = dz * inverse;
    z = length != 0.0 ? along_z : 1.0;
  }
};

template <bool uniform, bool damped, bool measured>
MASS_SPRING_INLINE void forces(const SpringLanes& springs, LaneResults<3>& force,
                               LaneResults<2>* energies) {
  const Difference d(springs.xi, springs.xj);
  const Difference w(springs.vi, springs.vj);
  const Value<uniform> stiffness(springs.stiffness), rest_length(springs.rest_length);
  const Value<uniform> damping(damped ? springs.damping : springs.stiffness);
  double* fx = force.of(0);
  double* fy = force.of(1);
  double* fz = force.of(2);
  double* elastic = measured ? energies->of(0) : nullptr;
  double* dissipation = measured ? energies->of(1) : nullptr;
  const std::uint32_t lanes = springs.lanes / SpringBatch::kLaneWidth * SpringBatch::kLaneWidth;
  MASS_SPRING_INDEPENDENT
  for (std::uint32_t s = 0; s < lanes; ++s) {
    const Direction n(d, s);
    const double stretch = n.length - rest_length[s];
    double f = stiffness[s] * stretch;
    if (measured) elastic[s] = 0.5 * f * stretch;
    if (damped) {
      const double rate = w.x(s) * n.x + w.y(s) * n.y + w.z(s) * n.z;
      const double loss = damping[s] * rate;
      f += loss;
      if (measured) dissipation[s] = 0.5 * loss * rate;
    } else if (measured) {
      dissipation[s] = 0.0;
    }
    fx[s] = f * n.x;
    fy[s] = f * n.y;
    fz[s] = f * n.z;
  }
}

template <bool measured>
MASS_SPRING_INLINE void forces(const SpringLanes& springs, LaneResults<3>& force,
                               LaneResults<2>* energies) {
  if (springs.uniform && springs.damped) {
    forces<true, true, measured>(springs, force, energies);
  } else if (springs.uniform) {
    forces<true, false, measured>(springs, force, energies);
  } else if (springs.damped) {
    forces<false, true, measured>(springs, force, energies);
  } else {
    forces<false, false, measured>(springs, force, energies);
  }
}

template <bool uniform>
MASS_SPRING_INLINE void indefiniteness(const SpringLanes& springs, double weight,
                                       LaneResults<1>& taken) {
  const Difference d(springs.xi, springs.xj);
  const Value<uniform> stiffness(springs.stiffness), rest_length(springs.rest_length);
  double* t = taken.of(0);
  const std::uint32_t lanes = springs.lanes / SpringBatch::kLaneWidth * SpringBatch::kLaneWidth;
  MASS_SPRING_INDEPENDENT
  for (std::uint32_t s = 0; s < lanes; ++s) {
    const double dx = d.x(s), dy = d.y(s), dz = d.z(s);
    const double compression = rest_length[s] / std::sqrt(dx * dx + dy * dy + dz * dz) - 1.0;
    // 0/0 of a spring without rest length whose ends coincide is not > 0; k = 0 takes nothing even
    // where r is infinite.
    const double share = 2.0 * weight * stiffness[s] * std::min(compression, 1e300);
    t[s] = compression > 0.0 ? share : 0.0;
  }
}

template <bool uniform, bool damped>
MASS_SPRING_INLINE void blocks(const SpringLanes& springs, const double* floor_i,
                               const double* floor_j, const MatrixWeights& weights,
                               LaneResults<6>& block, LaneResults<1>& projected) {
  const Difference d(springs.xi, springs.xj);
  const Value<uniform> stiffness(springs.stiffness), rest_length(springs.rest_length);
  const Value<uniform> damping(damped ? springs.damping : springs.stiffness);
  const double *fi = floor_i, *fj = floor_j;
  double *xx = block.of(0), *xy = block.of(1), *xz = block.of(2);
  double *yy = block.of(3), *yz = block.of(4), *zz = block.of(5);
  double* changed = projected.of(0);
  const double along_v = weights.damping, along_x = weights.stiffness;
  const std::uint32_t lanes = springs.lanes / SpringBatch::kLaneWidth * SpringBatch::kLaneWidth;
  MASS_SPRING_INDEPENDENT
  for (std::uint32_t s = 0; s < lanes; ++s) {
    const Direction n(d, s);
    const double k = along_x * stiffness[s];
    // Where the ends coincide, r is -infinity, and there is no exact derivative; without rest
    // length the spring is linear, and r = 1 also there.
    const double nowhere = rest_length[s] > 0.0 ? -1.0 : 1.0;
    const double exact = n.length != 0.0 ? 1.0 - rest_length[s] * n.inverse : nowhere;
    const double floor = n.length != 0.0 ? std::max(fi[s], fj[s]) : 0.0;
    const double r = std::max(exact, floor);
    changed[s] = (exact < floor && k > 0.0) ? 1.0 : 0.0;
    const double across = k * r;
    const double more_along = (damped ? k + along_v * damping[s] : k) - across;
    const double ax = more_along * n.x, ay = more_along * n.y, az = more_along * n.z;
    xx[s] = across + ax * n.x;
    xy[s] = ax * n.y;
    xz[s] = ax * n.z;
    yy[s] = across + ay * n.y;
    yz[s] = ay * n.z;
    zz[s] = across + az * n.z;
  }
}

/// to[s] += first * values[s], and to[apart + s] += second * values[s] for each lane; in one pass
/// where both meet, and in whole vectors there, as zeros surround the values.
template <int first, int second>
MASS_SPRING_INLINE void addTwice(const double* values, std::uint32_t count, std::uint32_t apart,
                                 double* to) {
  constexpr std::uint32_t width = SpringBatch::kLaneWidth;
  const std::uint32_t lanes = count / width * width;
  const bool meeting = apart < lanes;
  const std::uint32_t begin = meeting ? apart / width * width : apart;
  const std::uint32_t end = (meeting ? (apart + width - 1) / width * width : apart) + lanes;
  const std::uint32_t meet = std::min(begin, lanes), part = std::max(begin, lanes);
  const double* shifted = values - std::ptrdiff_t{apart};
  MASS_SPRING_INDEPENDENT
  for (std::uint32_t s = 0; s < meet; ++s) to[s] += first * values[s];
  MASS_SPRING_INDEPENDENT
  for (std::uint32_t s = begin; s < lanes; ++s) {
    to[s] = to[s] + first * values[s] + second * shifted[s];
  }
  MASS_SPRING_INDEPENDENT
  for (std::uint32_t s = part; s < end; ++s) to[s] += second * shifted[s];
}

template <int sign_at_j>
MASS_SPRING_INLINE void addToBothEnds(const double* values, const SpringBatch& run, double* to) {
  if (run.i < run.j) {
    addTwice<1, sign_at_j>(values, run.lanes, run.j - run.i, to + run.i);
  } else {
    addTwice<sign_at_j, 1>(values, run.lanes, run.i - run.j, to + run.j);
  }
}

template <bool uniform, bool damped>
MASS_SPRING_INLINE void relaxLanes(const SpringBatch& run, const SpringLanes& springs,
                                   const double* shares, const Relaxation& relaxation,
                                   std::uint32_t from, std::uint32_t count, LaneResults<3>& moved) {
  const std::uint32_t i = run.i + from, j = run.j + from;
  Columns& to = relaxation.positions;
  const Columns& from_there = relaxation.before;
  double *xi = to[0] + i, *yi = to[1] + i, *zi = to[2] + i;
  double *xj = to[0] + j, *yj = to[1] + j, *zj = to[2] + j;
  const Difference d({xi, yi, zi}, {xj, yj, zj});
  const Difference before({from_there[0] + i, from_there[1] + i, from_there[2] + i},
                          {from_there[0] + j, from_there[1] + j, from_there[2] + j});
  const std::uint32_t first = uniform ? 0 : from;
  const Value<uniform> stiffness(springs.stiffness + first);
  const Value<uniform> rest_length(springs.rest_length + first);
  const Value<uniform> damping((damped ? springs.damping : springs.stiffness) + first);
  const double* share = shares + from;
  double *mx = moved.of(0), *my = moved.of(1), *mz = moved.of(2);
  const double h = relaxation.h;
  const std::uint32_t lanes = count / SpringBatch::kLaneWidth * SpringBatch::kLaneWidth;
  MASS_SPRING_INDEPENDENT
  for (std::uint32_t s = 0; s < lanes; ++s) {
    const Direction n(d, s);
    double f = h * stiffness[s] * (n.length - rest_length[s]);
    if (damped) {
      const double approach = (d.x(s) - before.x(s)) * n.x + (d.y(s) - before.y(s)) * n.y +
                              (d.z(s) - before.z(s)) * n.z;
      f += damping[s] * approach;
    }
    const double move = h * f * share[s];
    mx[s] = move * n.x;
    my[s] = move * n.y;
    mz[s] = move * n.z;
  }
  const double *wi = relaxation.inverse_masses + i, *wj = relaxation.inverse_masses + j;
  MASS_SPRING_INDEPENDENT
  for (std::uint32_t s = 0; s < lanes; ++s) {
    xi[s] += wi[s] * mx[s];
    yi[s] += wi[s] * my[s];
    zi[s] += wi[s] * mz[s];
  }
  MASS_SPRING_INDEPENDENT
  for (std::uint32_t s = 0; s < lanes; ++s) {
    xj[s] -= wj[s] * mx[s];
    yj[s] -= wj[s] * my[s];
    zj[s] -= wj[s] * mz[s];
  }
}

template <bool uniform, bool damped>
MASS_SPRING_INLINE void relax(const SpringBatch& run, const SpringLanes& springs,
                              const double* shares, const Relaxation& relaxation) {
  LaneResults<3> moved;
  const std::uint32_t at_once = RelaxedLanes(run).lanes;
  for (std::uint32_t from = 0; from < run.lanes; from += at_once) {
    relaxLanes<uniform, damped>(run, springs, shares, relaxation, from,
                                std::min(at_once, run.lanes - from), moved);
  }
}

}  // namespace

RelaxedLanes::RelaxedLanes(const SpringBatch& run)
    : passes(1), lanes(run.lanes), group(run.i < run.j ? run.j - run.i : run.i - run.j) {
  constexpr std::uint32_t width = SpringBatch::kLaneWidth;
  if (group < width) {
    passes = 2;
  } else {
    lanes = std::min(lanes, group / width * width);
  }
}

MASS_SPRING_DISPATCH
void relaxRun(const SpringBatch& run, const SpringLanes& springs, const double* shares,
              const Relaxation& relaxation) {
  if (springs.uniform && springs.damped) {
    relax<true, true>(run, springs, shares, relaxation);
  } else if (springs.uniform) {
    relax<true, false>(run, springs, shares, relaxation);
  } else if (springs.damped) {
    relax<false, true>(run, springs, shares, relaxation);
  } else {
    relax<false, false>(run, springs, shares, relaxation);
  }
}

MASS_SPRING_DISPATCH
void separate(const Vectors& vectors, std::uint32_t from, std::uint32_t to, Columns& columns) {
  const double* in = vectors.data();
  double *x = columns[0], *y = columns[1], *z = columns[2];
  MASS_SPRING_INDEPENDENT
  for (std::size_t i = from; i < to; ++i) {
    x[i] = in[3 * i];
    y[i] = in[3 * i + 1];
    z[i] = in[3 * i + 2];
  }
}

MASS_SPRING_DISPATCH
void moveInto(Vectors& vectors, std::uint32_t from, std::uint32_t to, Columns& columns) {
  double* out = vectors.data();
  double *x = columns[0], *y = columns[1], *z = columns[2];
  MASS_SPRING_INDEPENDENT
  for (std::size_t i = from; i < to; ++i) {
    out[3 * i] += x[i];
    out[3 * i + 1] += y[i];
    out[3 * i + 2] += z[i];
    x[i] = y[i] = z[i] = 0.0;
  }
}

MASS_SPRING_DISPATCH
void moveInto(std::vector<SymmetricBlock>& blocks, std::uint32_t from, std::uint32_t to,
              Columns& columns) {
  SymmetricBlock* out = blocks.data();
  double *xx = columns[0], *xy = columns[1], *xz = columns[2];
  double *yy = columns[3], *yz = columns[4], *zz = columns[5];
  MASS_SPRING_INDEPENDENT
  for (std::size_t i = from; i < to; ++i) {
    out[i].xx += xx[i];
    out[i].xy += xy[i];
    out[i].xz += xz[i];
    out[i].yy += yy[i];
    out[i].yz += yz[i];
    out[i].zz += zz[i];
    xx[i] = xy[i] = xz[i] = yy[i] = yz[i] = zz[i] = 0.0;
  }
}

MASS_SPRING_DISPATCH
void springForces(const SpringLanes& springs, LaneResults<3>& force) {
  forces<false>(springs, force, nullptr);
}

MASS_SPRING_DISPATCH
void springForcesAndEnergies(const SpringLanes& springs, LaneResults<3>& force,
                             LaneResults<2>& energies) {
  forces<true>(springs, force, &energies);
}

MASS_SPRING_DISPATCH
void springIndefiniteness(const SpringLanes& springs, double weight, LaneResults<1>& taken) {
  if (springs.uniform) {
    indefiniteness<true>(springs, weight, taken);
  } else {
    indefiniteness<false>(springs, weight, taken);
  }
}

MASS_SPRING_DISPATCH
void springBlocks(const SpringLanes& springs, const double* floor_i, const double* floor_j,
                  const MatrixWeights& weights, LaneResults<6>& block, LaneResults<1>& projected) {
  if (springs.uniform && springs.damped) {
    blocks<true, true>(springs, floor_i, floor_j, weights, block, projected);
  } else if (springs.uniform) {
    blocks<true, false>(springs, floor_i, floor_j, weights, block, projected);
  } else if (springs.damped) {
    blocks<false, true>(springs, floor_i, floor_j, weights, block, projected);
  } else {
    blocks<false, false>(springs, floor_i, floor_j, weights, block, projected);
  }
}

MASS_SPRING_DISPATCH
double sumLanes(const double* values, std::uint32_t lanes) {
  constexpr std::uint32_t width = SpringBatch::kLaneWidth;
  double partial[width] = {};
  for (std::uint32_t s = 0; s < lanes; s += width) {
    for (std::uint32_t l = 0; l < width; ++l) partial[l] += values[s + l];
  }
  return ((partial[0] + partial[1]) + (partial[2] + partial[3])) +
         ((partial[4] + partial[5]) + (partial[6] + partial[7]));
}

MASS_SPRING_DISPATCH
void addLanes(const LaneResults<1>& values, const SpringBatch& run, double* column) {
  addToBothEnds<1>(values.of(0), run, column);
}

MASS_SPRING_DISPATCH
void addLanes(const LaneResults<3>& force, const SpringBatch& run, Columns& columns) {
  for (int axis = 0; axis < 3; ++axis) addToBothEnds<-1>(force.of(axis), run, columns[axis]);
}

MASS_SPRING_DISPATCH
void addLanes(const LaneResults<6>& block, const SpringBatch& run, Columns& columns) {
  for (int entry = 0; entry < 6; ++entry) addToBothEnds<1>(block.of(entry), run, columns[entry]);
}

MASS_SPRING_DISPATCH
void subtractBlocks(const LaneResults<6>& block, const std::uint32_t* slots, std::uint32_t lanes,
                    SymmetricBlock* blocks) {
  for (std::uint32_t s = 0; s < lanes; ++s) {
    SymmetricBlock& b = blocks[slots[s]];
    b.xx -= block.of(0)[s];
    b.xy -= block.of(1)[s];
    b.xz -= block.of(2)[s];
    b.yy -= block.of(3)[s];
    b.yz -= block.of(4)[s];
    b.zz -= block.of(5)[s];
  }
}

}  // namespace mass_spring
