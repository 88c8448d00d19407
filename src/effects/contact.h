#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "effects/effect.h"
#include "mass_spring_sim/shape.h"

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
class Contact : public Effect, public DrivingEffect, public ForeseeingEffect {
 public:
  /// @param shapes  of the scene
  /// @param masses  kg, per particle
  Contact(const ContactOptions& options, std::vector<Shape> shapes, const Eigen::VectorXd& masses);

  /// All contacts at a state, particle by particle.
  std::vector<Touch> touches(const Point& point, Scratch* scratch) const;

  std::unique_ptr<Scratch> makeScratch(ThreadPool& threads) const override;
  void add(const Point& point, Scratch* scratch, const Sums& sums) const override;
  void addForceDerivative(const Point& point, Scratch* scratch, const Vectors& dx,
                          const Vectors& dv, Vectors& df) const override;
  std::uint32_t addDerivatives(const Point& point, Scratch* scratch, const MatrixWeights& weights,
                               Projection projection, StepMatrix& matrix) const override;
  /// About the positions that are to be expected: what a step leads into a shape is kept out by
  /// that step already. Of what slides too fast for a step to stop it, friction is a force of full
  /// size and D acts only across the sliding; of the rest, all friction is damping, by the secant.
  std::uint32_t linearize(const Point& point, Scratch* scratch, double w, StepMatrix& matrix,
                          Vectors& forces) const override;
  /// A particle that ends in a shape itself, beyond its thickness, should have been kept out.
  bool linearizationCovered(const Point& end, Scratch* scratch) const override;
  void addBounds(Eigen::VectorXd& stiffness, Eigen::VectorXd& damping) const override;
  /// Does a shape move?
  bool dependsOnTime(const Point& point) const override;
  double power(const Point& point, Scratch* scratch) const override;

 private:
  struct Room;
  /// |g| / |u| [s/m] and its derivative along u, times |u|.
  struct Slip {
    double secant, slope;
  };
  Slip slip(double speed) const;
  /// N, on a particle at x [m] of velocity v [m/s] that is so deep in a shape [m].
  Eigen::Vector3d force(const PlacedShape& shape, const Surface& surface, double depth,
                        const Eigen::Vector3d& x, const Eigen::Vector3d& v) const;
  /// The shapes where they are then.
  const std::vector<PlacedShape>& place(const Point& point, Scratch* scratch) const;
  /// visit(particle, shape number, surface, depth) of all contacts.
  template <typename Visit>
  void forEachContact(const std::vector<PlacedShape>& shapes, const Vectors& positions,
                      Visit visit) const;

  ContactOptions options_;
  double friction_;
  std::vector<Shape> shapes_;
  Eigen::VectorXd masses_;
};

}  // namespace mass_spring
