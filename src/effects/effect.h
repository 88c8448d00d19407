#pragma once

#include <cstdint>
#include <limits>
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

  /// Are its forces always the same?
  virtual bool constant() const { return false; }

  /// What depends on time is from now on as it is then [s]. @return whether anything does
  virtual bool setTime(double /*time*/) { return false; }

  /// A sub-step of h [s] begins at this state. Until it ends, the forces may depend on the side
  /// from which particles come.
  virtual void beginSubstep(const Vectors& /*positions*/, const Vectors& /*velocities*/,
                            double /*h*/) {}
  /// It ends here. @return whether something has passed through something else on the way
  virtual bool endSubstep(const Vectors& /*positions*/) { return false; }

  /// Adds the force on each particle [N].
  virtual void addForces(const Vectors& positions, const Vectors& velocities,
                         Vectors& forces) const = 0;

  /// The same, and adds energy and Q [W] at that point: what energy methods need, cheaper than one
  /// after the other. With x held, -dQ/dv is the part of the force that depends on velocities; of
  /// forces linear in v, Q is half the power lost.
  virtual void addForces(const Vectors& positions, const Vectors& velocities, Vectors& forces,
                         Energy& energy, double& dissipation) const = 0;

  /// Does Q depend on the positions?
  virtual bool dampingTurns() const { return false; }
  /// The same forces, with Q as it is at the positions `held`.
  virtual void addForcesHolding(const Vectors& /*held*/, const Vectors& positions,
                                const Vectors& velocities, Vectors& forces, Energy& energy,
                                double& dissipation) const {
    addForces(positions, velocities, forces, energy, dissipation);
  }

  /// What it may feed into the particles at most [W], where it can: the moving air, a moving shape.
  virtual double power(const Vectors& /*positions*/, const Vectors& /*velocities*/) const {
    return 0.0;
  }

  /// m, over which it changes much: displacements are known when they are small against that.
  /// Infinite where it is linear, or has the springs' lengths.
  virtual double length() const { return std::numeric_limits<double>::infinity(); }

  /// Adds to each particle bounds of what holds it in place [N/m] and of what brakes it [N s/m],
  /// whatever the positions; springs, which join particles, are counted elsewhere.
  virtual void addBounds(Eigen::VectorXd& /*stiffness*/, Eigen::VectorXd& /*damping*/) const {}

  /// df += (df/dx) dx + (df/dv) dv: how the forces change with positions and velocities, exactly
  /// and unprojected, also where the step matrix leaves terms out.
  virtual void addForceDerivative(const Vectors& /*x*/, const Vectors& /*v*/, const Vectors& /*dx*/,
                                  const Vectors& /*dv*/, Vectors& /*df*/) const {}

  /// Names the pairs of particles whose blocks the matrix needs; then looks them up, once.
  virtual void addPattern(PatternBuilder& /*pattern*/) const {}
  virtual void findSlots(const BlockPattern& /*pattern*/) {}
  /// Whether it may tie together particles outside the pattern (see Tie).
  virtual bool ties() const { return false; }

  /// Adds the weighted D and K to a matrix that holds the weighted masses.
  /// @return how many elements were projected
  virtual std::uint32_t addDerivatives(const Vectors& /*positions*/, const Vectors& /*velocities*/,
                                       const MatrixWeights& /*weights*/, Projection /*projection*/,
                                       StepMatrix& /*matrix*/) const {
    return 0;
  }

  /// What a linearly implicit step of w [s] takes of the effect: adds w D + w^2 K, projected, to
  /// the matrix, and to the forces f + D v, so that what is left at the new velocities u is f + D v
  /// - D u - w K u.
  virtual std::uint32_t linearize(const Vectors& positions, const Vectors& velocities, double w,
                                  StepMatrix& matrix, Vectors& forces) const = 0;
  /// Did the linearization of a step see coming what is at its end? If not, the next linearize(),
  /// of the same step, looks there, too.
  virtual bool foresaw(const Vectors& /*ends*/) const { return true; }
};

/// Sum over the model's effects, and the external loads if there are any [N].
void sumForces(const Model& model, const Vectors* loads, const Vectors& positions,
               const Vectors& velocities, Vectors& forces);
/// The same, and adds the effects' energy [J] and Q [W].
/// @param held  positions that give damping its directions; nullptr = those of the particles
void sumForces(const Model& model, const Vectors* loads, const Vectors* held,
               const Vectors& positions, const Vectors& velocities, Vectors& forces, Energy& energy,
               double& dissipation);

/// Effects are constant but for the time that they are at: that of whoever computes with them.
bool setTime(const Model& model, double time);

void beginSubstep(const Model& model, const Vectors& positions, const Vectors& velocities,
                  double h);
/// @return whether something has passed through something else
bool endSubstep(const Model& model, const Vectors& positions);

}  // namespace mass_spring
