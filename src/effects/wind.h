#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "effects/effect.h"

namespace mass_spring {

/// Air that moves past faces (Keckeisen, Kimmerle, Thomaszewski and Wacker, "Modelling effects of
/// wind fields in cloth animations", 2004). With the area vector S = A n, the velocity u of the air
/// relative to the mean of the corners, and q = S . u, what a face feels is
///   F = rho / 2 (C_D |q| u + C_L q (|u| n - (n . u) u / |u|)),
/// either way round its normal: drag of size rho / 2 C_D A |u|^2 cos(angle) along u, and lift of
/// size rho / 2 C_L A |u|^2 cos(angle) sin(angle) across u, towards the normal. A third of it goes
/// to each corner. Faces do not shield one another; the sides of a closed mesh feel the air each.
///
/// F has no potential. Q = - integral of F(x, s v) . v over s in [0, 1], by Simpson's rule: exact
/// where F is quadratic in s, as it is in still air, and along straight motion into the wind. The
/// matrix has D = rho / 2 C_D |q| (I + n n^T) / 3 per corner, no less than drag's own where u is
/// along n; all else stays out: what couples corners, drag's skew part, lift, whose derivative is
/// indefinite, and K, which is not symmetric. So everything is on the diagonal.
class Wind : public Effect, public DrivingEffect {
 public:
  /// @param model  has its particles and triangles already
  Wind(const WindOptions& options, const Model& model);

  void add(const Point& point, Scratch* scratch, const Sums& sums) const override;
  /// Only a gust does.
  bool dependsOnTime(const Point& /*point*/) const override { return options_.gust.has_value(); }
  /// What the corners take up that the air pushes on, without those that it brakes.
  double power(const Point& point, Scratch* scratch) const override;
  /// For faces as large as at the start, that move at most as fast as the wind blows or as any
  /// particle does at the start.
  void addBounds(Eigen::VectorXd& stiffness, Eigen::VectorXd& damping) const override;
  void addForceDerivative(const Point& point, Scratch* scratch, const Vectors& dx,
                          const Vectors& dv, Vectors& df) const override;
  std::uint32_t addDerivatives(const Point& point, Scratch* scratch, const MatrixWeights& weights,
                               Projection projection, StepMatrix& matrix) const override;
  std::uint32_t linearize(const Point& point, Scratch* scratch, double w, StepMatrix& matrix,
                          Vectors& forces) const override;

 private:
  using Corners = std::array<std::uint32_t, 3>;
  /// m/s, of the air.
  Eigen::Vector3d velocityAt(double time) const;
  /// N, on a face of the area vector S [m^2] in the relative wind u [m/s].
  Eigen::Vector3d force(const Eigen::Vector3d& S, const Eigen::Vector3d& u) const;

  WindOptions options_;
  double drag_, lift_;  // kg/m^3, rho / 2 times the coefficients
  std::vector<Corners> faces_;
  Eigen::VectorXd damping_bounds_;  // N s/m, see addBounds()
};

}  // namespace mass_spring
