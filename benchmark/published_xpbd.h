#pragma once

#include "rival.h"

namespace mass_spring {

/// Extended position based dynamics as published: M. Macklin, M. Mueller, N. Chentanez, "XPBD:
/// position-based simulation of compliant constrained dynamics" (2016), algorithm 1, with sub-steps
/// as in M. Macklin et al., "Small steps in physics simulation" (2019). One distance constraint of
/// compliance 1 / stiffness per spring, damped by eq. 26, Gauss-Seidel in double precision. Springs
/// of no stiffness are left out: their compliance is infinite.
class PublishedXpbd : public Rival {
 public:
  enum class Order {
    kOfSprings,  ///< as the model lists them
    kByColor,    ///< no two in a row share a particle: the processor can overlap them
  };

  /// @param substeps    >= 1, of each step
  /// @param iterations  >= 1, over all constraints in each sub-step
  PublishedXpbd(const RivalScene& scene, int substeps, int iterations, Order order);

  void step() override;
  Vectors positions() const override;

 private:
  struct Particle {
    Eigen::Vector3d x;
    double inverse_mass;  // 1/kg, 0 = pinned
  };
  struct Constraint {
    std::uint32_t i, j;
    double rest_length;
    double compliance;   // alpha / h^2
    double damping;      // gamma
    double denominator;  // 1 / ((1 + gamma) (w_i + w_j) + alpha / h^2)
  };
  void project();
  void projectOnce();

  double h_;
  int substeps_, iterations_;
  Eigen::Vector3d gravity_;
  std::vector<Particle> particles_;
  std::vector<Eigen::Vector3d> before_, velocities_;
  std::vector<Constraint> constraints_;
  std::vector<double> multipliers_;
};

/// Sub-steps from 1 on with one iteration, in both orders, and one step of 10, 50 iterations and
/// more.
std::vector<RivalSeries> xpbdSeries();

}  // namespace mass_spring
