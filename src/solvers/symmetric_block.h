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

  /// The inverse by Cramer's rule. @return false if the block is not positive definite.
  bool invert(SymmetricBlock& inverse) const {
    const double a = yy * zz - yz * yz;
    const double b = xz * yz - xy * zz;
    const double c = xy * yz - xz * yy;
    const double determinant = xx * a + xy * b + xz * c;
    // Sylvester's criterion; a NaN fails it too.
    if (!(xx > 0.0 && xx * yy - xy * xy > 0.0 && determinant > 0.0)) return false;
    const double s = 1.0 / determinant;
    inverse = {s * a,
               s * b,
               s * c,
               s * (xx * zz - xz * xz),
               s * (xy * xz - xx * yz),
               s * (xx * yy - xy * xy)};
    return true;
  }
};

}  // namespace mass_spring
