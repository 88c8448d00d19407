#include "stability_function.h"

#include <Eigen/LU>
#include <cmath>
#include <string>

namespace mass_spring {

std::optional<Eigen::Matrix2d> stabilityFunction(Scheme scheme, double h, double w2, double c) {
  using Matrix = Eigen::Matrix2d;
  const Matrix one = Matrix::Identity();
  const Matrix z = h * (Matrix() << 0.0, 1.0, -w2, -c).finished();
  const std::string& name = info(scheme).name;
  if (name == "explicit_euler") return one + z;
  if (name == "symplectic_euler") {
    // u' = v' with the new velocity: no function of z alone.
    return (Matrix() << 1.0 - h * h * w2, h - h * h * c, -h * w2, 1.0 - h * c).finished();
  }
  if (name == "rk4") return one + z + z * z / 2.0 + z * z * z / 6.0 + z * z * z * z / 24.0;
  // xpbd with one spring: there is no other that it does not hear of.
  if (name == "linear_implicit_euler" || name == "implicit_euler" || name == "xpbd") {
    return (one - z).inverse();
  }
  if (name == "implicit_midpoint") return (one - z / 2.0).inverse() * (one + z / 2.0);
  if (name == "tr_bdf2") {
    // gamma = 2 - sqrt(2): both stages have the coefficient gamma / 2 = 1 - 1/sqrt(2).
    const double delta = 1.0 - 1.0 / std::sqrt(2.0);
    const Matrix denominator = (one - delta * z) * (one - delta * z);
    return denominator.inverse() * (one + (1.0 - 2.0 * delta) * z);
  }
  if (name == "ros3") {
    // Three stages with one diagonal coefficient g, order 3, R(infinity) = 0: the numerator agrees
    // with (1 - g z)^3 e^z up to z^2, and g is the root of 1/6 - 3g/2 + 3g^2 - g^3 for which R is
    // A-stable (Hairer, Wanner, Solving ODEs II, 1996, IV.6).
    const double g = 0.435866521508458999416019;
    const Matrix factor = one - g * z;
    const Matrix numerator = one + (1.0 - 3.0 * g) * z + (0.5 - 3.0 * g + 3.0 * g * g) * z * z;
    return (factor * factor * factor).inverse() * numerator;
  }
  return std::nullopt;
}

}  // namespace mass_spring
