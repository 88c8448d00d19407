#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "effects/effect.h"
#include "effects/shape.h"

namespace mass_spring {

/// Shapes that particles rest on and rub on. With the depth p = thickness - distance > 0 and the
/// normal n, E = k p^2 / 2 and N = k p along n: K = k n n^T - N (dn/dx), of which the second part
/// is dropped where a matrix has to be definite. Friction is Coulomb's, f = -mu N g(u) with the
/// sliding velocity u across n, made smooth below the slip velocity e (Li et al., "Incremental
/// potential contact", 2020): |g| = 2 y - y^2 for y = |u| / e < 1, else 1. It has the potential
/// Q = mu N G(u), and D = mu N dg/du; projected, D is the secant mu N |g| / |u|, with which a
/// linearized step never overshoots a standstill. That N and n turn with x stays out of the matrix.
/// Where a shape moves, u is what the particle has beyond the velocity of the place it touches.
/// Everything is on the diagonal of the matrix: the pattern stays what it was.
class Contact : public Effect {
 public:
  /// @param masses  kg, per particle
  Contact(const ContactOptions& options, const Eigen::VectorXd& masses);

  std::vector<std::string> names() const override;
  /// All contacts at a state, particle by particle.
  std::vector<Touch> touches(const Vectors& positions, const Vectors& velocities) const;
  const std::vector<Shape>& shapes() const { return shapes_; }
  /// nullptr if there is none of that name.
  Shape* find(const std::string& name);
  void reset();  ///< all shapes at their start, at rest
  /// Shapes that start where those of another contact do, and have their names, go on as those do.
  void continueFrom(const Contact& other);

  bool setTime(double time) override;
  double power(const Vectors& positions, const Vectors& velocities) const override;

  void addEnergy(const Vectors& positions, Energy& energy) const override;
  void addForces(const Vectors& positions, const Vectors& velocities,
                 Vectors& forces) const override;
  void addForces(const Vectors& positions, const Vectors& velocities, Vectors& forces,
                 Energy& energy, double& dissipation) const override;
  void addForcesHolding(const Vectors& held, const Vectors& positions, const Vectors& velocities,
                        Vectors& forces, Energy& energy, double& dissipation) const override;
  bool dampingTurns() const override { return friction_ > 0.0; }
  void addForceDerivative(const Vectors& x, const Vectors& v, const Vectors& dx, const Vectors& dv,
                          Vectors& df) const override;
  std::uint32_t addDerivatives(const Vectors& positions, const Vectors& velocities,
                               const MatrixWeights& weights, Projection projection,
                               StepMatrix& matrix) const override;
  /// About the positions that are to be expected: what a step leads into a shape is kept out by
  /// that step already. Of what slides too fast for a step to stop it, friction is a force of full
  /// size and D acts only across the sliding; of the rest, all friction is damping, by the secant.
  std::uint32_t linearize(const Vectors& positions, const Vectors& velocities, double w,
                          StepMatrix& matrix, Vectors& forces) const override;
  /// A particle that ends in a shape itself, beyond its thickness, should have been kept out.
  bool foresaw(const Vectors& ends) const override;
  void addBounds(Eigen::VectorXd& stiffness, Eigen::VectorXd& damping) const override;
  double length() const override;

 private:
  /// |g| / |u| [s/m] and its derivative along u, times |u|.
  struct Slip {
    double secant, slope;
  };
  Slip slip(double speed) const;
  /// N, on a particle at x [m] of velocity v [m/s] that is so deep in a shape [m].
  Eigen::Vector3d force(const Shape& shape, const Surface& surface, double depth,
                        const Eigen::Vector3d& x, const Eigen::Vector3d& v) const;
  /// visit(particle, shape number, surface, depth) of all contacts.
  template <typename Visit>
  void forEachContact(const Vectors& positions, Visit visit) const;

  ContactOptions options_;
  double friction_;
  std::vector<Shape> shapes_;
  Eigen::VectorXd masses_;
  // The particles and shapes that the last linearized step knew of (particle by particle), and
  // where that step ended if it was in a shape it did not know of.
  mutable std::vector<char> known_;
  mutable Vectors ends_;
  mutable bool missed_ = false;
};

}  // namespace mass_spring
