#pragma once

#include <string>

#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/state.h"

namespace mass_spring {

class PatternBuilder;
class StepMatrix;

/// Whatever adds energy or force. With K = -df/dx and D = -df/dv, the step matrix is
/// alpha_a M + alpha_v D + alpha_x K.
struct MatrixWeights {
  double mass;       ///< alpha_a
  double damping;    ///< alpha_v
  double stiffness;  ///< alpha_x
};

/// One physical effect. An effect that a scene does not call for is not in the model's list.
class Effect {
 public:
  virtual ~Effect() = default;
  virtual std::string name() const = 0;
  /// Adds the potential energy [J] to the entry it belongs to.
  virtual void addEnergy(const Vectors& positions, Energy& energy) const;
  /// Adds the force on each particle [N].
  virtual void addForces(const Vectors& positions, const Vectors& velocities,
                         Vectors& forces) const = 0;
  /// Names the pairs of particles whose blocks the matrix needs.
  virtual void addPattern(PatternBuilder& pattern) const;
  /// Adds alpha_v D + alpha_x K, made positive semidefinite where the masses alone could not keep
  /// the matrix definite. Returns how many elements were projected.
  virtual std::uint32_t addDerivatives(const Vectors& positions, const Vectors& velocities,
                                       const MatrixWeights& weights,
                                       const Eigen::VectorXd& masses, StepMatrix& matrix) const;
  /// Power loss as a potential of the velocities [W/2]: -dQ/dv is the force. 0 if conservative.
  virtual double dissipation(const Vectors& positions, const Vectors& velocities) const;
};

}  // namespace mass_spring
