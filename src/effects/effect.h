#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/model.h"
#include "mass_spring_sim/state.h"

namespace mass_spring {

class BlockPattern;
class PatternBuilder;
class StepMatrix;

/// With K = -df/dx and D = -df/dv, the step matrix is mass M + damping D + stiffness K.
struct MatrixWeights {
  double mass;       ///< alpha_a
  double damping;    ///< alpha_v [s]
  double stiffness;  ///< alpha_x [s^2]
};

/// What becomes of elements whose stiffness is not positive semidefinite.
enum class Projection {
  kNone,         ///< they stay: the matrix is exact, and may be indefinite
  kWhereNeeded,  ///< projected where the masses alone could not keep the matrix definite
};

/// Whatever adds energy or force. An effect that a scene does not call for is not in the model's
/// list, and so has no entries in the pattern, no memory and no branch inside a loop.
class Effect {
 public:
  virtual ~Effect() = default;
  /// What it is called where active effects are listed; more than one if it joins several.
  virtual std::vector<std::string> names() const = 0;

  /// Adds the potential energy [J] to the entry it belongs to.
  virtual void addEnergy(const Vectors& /*positions*/, Energy& /*energy*/) const {}

  /// Q = v^T D v / 2 [W], half the power lost; with x held, -dQ/dv is the damping force.
  virtual double dissipation(const Vectors& /*positions*/, const Vectors& /*velocities*/) const {
    return 0.0;
  }

  /// Adds the force on each particle [N].
  virtual void addForces(const Vectors& positions, const Vectors& velocities,
                         Vectors& forces) const = 0;

  /// The same, and adds energy and half the power lost at that point: what energy methods need,
  /// cheaper than one after the other.
  virtual void addForces(const Vectors& positions, const Vectors& velocities, Vectors& forces,
                         Energy& energy, double& dissipation) const = 0;

  /// df += (df/dx) dx + (df/dv) dv: how the forces change with positions and velocities, exactly
  /// and unprojected, also where the step matrix leaves terms out.
  virtual void addForceDerivative(const Vectors& /*x*/, const Vectors& /*v*/, const Vectors& /*dx*/,
                                  const Vectors& /*dv*/, Vectors& /*df*/) const {}

  /// Names the pairs of particles whose blocks the matrix needs; then looks them up, once.
  virtual void addPattern(PatternBuilder& /*pattern*/) const {}
  virtual void findSlots(const BlockPattern& /*pattern*/) {}

  /// Adds the weighted D and K to a matrix that holds the weighted masses.
  /// @return how many elements were projected
  virtual std::uint32_t addDerivatives(const Vectors& /*positions*/,
                                       const MatrixWeights& /*weights*/, Projection /*projection*/,
                                       StepMatrix& /*matrix*/) const {
    return 0;
  }
};

/// Sum over the model's effects, and the external loads if there are any [N].
void sumForces(const Model& model, const Vectors* loads, const Vectors& positions,
               const Vectors& velocities, Vectors& forces);
/// The same, and adds the effects' energy [J] and half the power that they lose [W].
void sumForces(const Model& model, const Vectors* loads, const Vectors& positions,
               const Vectors& velocities, Vectors& forces, Energy& energy, double& dissipation);

}  // namespace mass_spring
