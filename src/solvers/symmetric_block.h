#pragma once

#include <Eigen/Core>

namespace mass_spring {

/// A symmetric 3x3 matrix by its six entries. Every block of a spring's matrices is one.
struct SymmetricBlock {
  double xx = 0.0, xy = 0.0, xz = 0.0, yy = 0.0, yz = 0.0, zz = 0.0;

  /// across I + (along - across) n n^T: eigenvalue `along` along the unit vector n, `across` twice.
  static SymmetricBlock axial(const Eigen::Vector3d& n, double along, double across) {
    const Eigen::Vector3d a = (along - across) * n;
    return {across + a.x() * n.x(), a.x() * n.y(), a.x() * n.z(),
            across + a.y() * n.y(), a.y() * n.z(), across + a.z() * n.z()};
  }
  static SymmetricBlock isotropic(double value) { return {value, 0.0, 0.0, value, 0.0, value}; }

  SymmetricBlock& operator+=(const SymmetricBlock& b) {
    xx += b.xx, xy += b.xy, xz += b.xz, yy += b.yy, yz += b.yz, zz += b.zz;
    return *this;
  }
  SymmetricBlock& operator-=(const SymmetricBlock& b) {
    xx -= b.xx, xy -= b.xy, xz -= b.xz, yy -= b.yy, yz -= b.yz, zz -= b.zz;
    return *this;
  }
  Eigen::Matrix3d dense() const {
    return (Eigen::Matrix3d() << xx, xy, xz, xy, yy, yz, xz, yz, zz).finished();
  }

  /// y += B x for three contiguous numbers each.
  void multiplyAdd(const double* x, double* y) const {
    y[0] += xx * x[0] + xy * x[1] + xz * x[2];
    y[1] += xy * x[0] + yy * x[1] + yz * x[2];
    y[2] += xz * x[0] + yz * x[1] + zz * x[2];
  }

  /// The inverse by L D L^T, whose pivots bear contrasts up to 1e16 (Cramer's determinant: only up
  /// to 1e8). @return false if the block is not positive definite.
  bool invert(SymmetricBlock& inverse) const {
    const double d1 = 1.0 / xx;
    const double l21 = xy * d1, l31 = xz * d1;
    const double p2 = yy - l21 * xy;
    const double q = yz - l31 * xy;
    const double d2 = 1.0 / p2;
    const double l32 = q * d2;
    const double p3 = zz - l31 * xz - l32 * q;
    if (!(xx > 0.0 && p2 > 0.0 && p3 > 0.0)) return false;  // a NaN fails it too
    const double d3 = 1.0 / p3;
    const double m31 = l21 * l32 - l31;  // of L^-1
    inverse.zz = d3;
    inverse.yz = -l32 * d3;
    inverse.xz = m31 * d3;
    inverse.yy = d2 - l32 * inverse.yz;
    inverse.xy = -l21 * d2 - l32 * inverse.xz;
    inverse.xx = d1 + l21 * l21 * d2 + m31 * inverse.xz;
    return true;
  }
};

}  // namespace mass_spring
