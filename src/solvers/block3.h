#pragma once

#include <cmath>

#include "solvers/symmetric_block.h"

namespace mass_spring {

/// The Cholesky factor C of a pivot block, C C^T, lower triangular, with the inverses of its
/// diagonal. Eliminating with C, by substitution, is backward stable; multiplying by the pivot's
/// inverse is not: where a light particle hangs on stiff springs it loses the square of the pivot's
/// condition number (Higham, Accuracy and Stability of Numerical Algorithms, 2002, ch. 13).
struct PivotBlock {
  double i0 = 0.0, i1 = 0.0, i2 = 0.0, c10 = 0.0, c20 = 0.0, c21 = 0.0;

  /// @return false if the block is not positive definite (or not a number)
  bool factorize(const SymmetricBlock& s) {
    i0 = 1.0 / std::sqrt(s.xx);
    c10 = s.xy * i0;
    c20 = s.xz * i0;
    const double d1 = s.yy - c10 * c10;
    i1 = 1.0 / std::sqrt(d1);
    c21 = (s.yz - c10 * c20) * i1;
    const double d2 = s.zz - c20 * c20 - c21 * c21;
    i2 = 1.0 / std::sqrt(d2);
    return s.xx > 0.0 && d1 > 0.0 && d2 > 0.0;
  }
  /// y = C^-1 y
  void solve(double* y) const {
    y[0] *= i0;
    y[1] = (y[1] - c10 * y[0]) * i1;
    y[2] = (y[2] - c20 * y[0] - c21 * y[1]) * i2;
  }
  /// y = C^-T y
  void solveTransposed(double* y) const {
    y[2] *= i2;
    y[1] = (y[1] - c21 * y[2]) * i1;
    y[0] = (y[0] - c10 * y[1] - c20 * y[2]) * i0;
  }
};

/// A general 3x3 block of a triangular factor, row-major.
struct Block3 {
  double a[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0};

  static Block3 from(const SymmetricBlock& s) {
    return {{s.xx, s.xy, s.xz, s.xy, s.yy, s.yz, s.xz, s.yz, s.zz}};
  }

  /// this -= l r^T
  void subtractProductTransposed(const Block3& l, const Block3& r) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        a[3 * i + j] -= l.a[3 * i] * r.a[3 * j] + l.a[3 * i + 1] * r.a[3 * j + 1] +
                        l.a[3 * i + 2] * r.a[3 * j + 2];
      }
    }
  }

  /// this s
  Block3 times(const SymmetricBlock& s) const {
    Block3 p;
    for (int i = 0; i < 3; ++i) {
      const double x = a[3 * i], y = a[3 * i + 1], z = a[3 * i + 2];
      p.a[3 * i + 0] = x * s.xx + y * s.xy + z * s.xz;
      p.a[3 * i + 1] = x * s.xy + y * s.yy + z * s.yz;
      p.a[3 * i + 2] = x * s.xz + y * s.yz + z * s.zz;
    }
    return p;
  }

  /// s -= this l^T, where the product is known to be symmetric.
  void subtractSymmetricProduct(const Block3& l, SymmetricBlock& s) const {
    const auto entry = [&](int i, int j) {
      return a[3 * i] * l.a[3 * j] + a[3 * i + 1] * l.a[3 * j + 1] + a[3 * i + 2] * l.a[3 * j + 2];
    };
    s.xx -= entry(0, 0), s.xy -= entry(0, 1), s.xz -= entry(0, 2);
    s.yy -= entry(1, 1), s.yz -= entry(1, 2), s.zz -= entry(2, 2);
  }

  /// y -= this x
  void multiplySubtract(const double* x, double* y) const {
    y[0] -= a[0] * x[0] + a[1] * x[1] + a[2] * x[2];
    y[1] -= a[3] * x[0] + a[4] * x[1] + a[5] * x[2];
    y[2] -= a[6] * x[0] + a[7] * x[1] + a[8] * x[2];
  }

  /// y -= this^T x
  void multiplyTransposedSubtract(const double* x, double* y) const {
    y[0] -= a[0] * x[0] + a[3] * x[1] + a[6] * x[2];
    y[1] -= a[1] * x[0] + a[4] * x[1] + a[7] * x[2];
    y[2] -= a[2] * x[0] + a[5] * x[1] + a[8] * x[2];
  }
};

}  // namespace mass_spring
