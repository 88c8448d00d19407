#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/model.h"
#include "mass_spring_sim/state.h"

namespace mass_spring {

class BlockPattern;
class PatternBuilder;
class StepMatrix;
class ThreadPool;

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

/// The state at which effects are evaluated.
struct Point {
  const Vectors& positions;    ///< m
  const Vectors& velocities;   ///< m/s
  double time;                 ///< s
  const EffectState& effects;  ///< the memory of the effects
};

/// The sums over the effects that a caller asks for; a null pointer means that it does not want
/// one.
struct Sums {
  Vectors* forces = nullptr;  ///< N
  Energy* energy = nullptr;   ///< J, each to the entry it belongs to
  /// Q [W]: with x held, -dQ/dv is the part of the forces that depends on velocities; of forces
  /// linear in v, Q is half the power lost. Only together with forces.
  double* dissipation = nullptr;
  /// m, positions that give Q, and the forces that come of it, in place of those of the point.
  const Vectors* damping_positions = nullptr;
};

/// The constant properties of an effect.
struct Traits {
  /// The names in lists of active effects; an effect that joins several has more than one.
  std::vector<std::string> names;
  bool constant = false;                     ///< its forces are always the same
  bool damping_depends_on_position = false;  ///< Q does
  bool ties = false;  ///< it may tie together particles outside the pattern (see Tie)
  /// m, over which it changes much: displacements are known when they are small against that.
  /// Infinite where it is linear, or has the springs' lengths.
  double length = std::numeric_limits<double>::infinity();
};

/// The memory that an effect computes with. It changes no answer, except within one sub-step.
class Scratch {
 public:
  virtual ~Scratch() = default;
};

/// An effect adds energy or force. An effect that a scene does not call for is not in the model's
/// list, and so has no entries in the pattern, no memory and no branch inside a loop. Effects are
/// constant: what changes is in the point and in the scratch, which each caller has of its own.
/// @param scratch  of this effect, from makeScratch()
class Effect {
 public:
  explicit Effect(Traits traits) : traits_(std::move(traits)) {}
  virtual ~Effect() = default;
  const Traits& traits() const { return traits_; }

  /// nullptr if it needs none.
  virtual std::unique_ptr<Scratch> makeScratch(ThreadPool& /*threads*/) const { return nullptr; }

  /// Adds up its energy, forces and Q.
  virtual void add(const Point& point, Scratch* scratch, const Sums& sums) const = 0;

  /// df += (df/dx) dx + (df/dv) dv: how the forces change with positions and velocities, exactly
  /// and unprojected, also where the step matrix leaves terms out.
  virtual void addForceDerivative(const Point& /*point*/, Scratch* /*scratch*/,
                                  const Vectors& /*dx*/, const Vectors& /*dv*/,
                                  Vectors& /*df*/) const {}

  /// Adds the weighted D and K to a matrix that holds the weighted masses.
  /// @return how many elements were projected
  virtual std::uint32_t addDerivatives(const Point& /*point*/, Scratch* /*scratch*/,
                                       const MatrixWeights& /*weights*/, Projection /*projection*/,
                                       StepMatrix& /*matrix*/) const {
    return 0;
  }

  /// What a linearly implicit step of w [s] takes of the effect: adds w D + w^2 K, projected, to
  /// the matrix, and to the forces f + D v, so that what is left at the new velocities u is f + D v
  /// - D u - w K u.
  virtual std::uint32_t linearize(const Point& point, Scratch* scratch, double w,
                                  StepMatrix& matrix, Vectors& forces) const = 0;

  /// Adds to each particle bounds of what holds it in place [N/m] and of what brakes it [N s/m],
  /// whatever the positions; springs, which join particles, are counted elsewhere.
  virtual void addBounds(Eigen::VectorXd& /*stiffness*/, Eigen::VectorXd& /*damping*/) const {}

  /// Names the pairs of particles whose blocks the matrix needs; then, while the model is built,
  /// looks them up, once.
  virtual void addPattern(PatternBuilder& /*pattern*/) const {}
  virtual void findSlots(const BlockPattern& /*pattern*/) {}

 protected:
  Traits traits_;
};

/// An effect that can feed energy into the particles: moving air, shapes that move.
class DrivingEffect {
 public:
  virtual ~DrivingEffect() = default;
  /// Does it depend on time, then or later?
  virtual bool dependsOnTime(const Point& point) const = 0;
  /// An upper bound of the power that the effect feeds in [W].
  virtual double power(const Point& point, Scratch* scratch) const = 0;
};

/// An effect that looks at a sub-step as a whole. Until the sub-step ends, its forces may depend on
/// the side from which particles come.
class SweptEffect {
 public:
  virtual ~SweptEffect() = default;
  /// A sub-step of h [s] begins at these positions.
  virtual void beginSubstep(Scratch& scratch, const Vectors& positions, const Vectors& velocities,
                            double h) const = 0;
  /// It ends here. @return whether something has passed through something else on the way
  virtual bool endSubstep(Scratch& scratch, const Vectors& positions) const = 0;
};

/// An effect whose linearization looks ahead.
class ForeseeingEffect {
 public:
  virtual ~ForeseeingEffect() = default;
  /// Did the last linearize() see coming what is where its step ends? If not, the next one, of the
  /// same step, looks there, too.
  virtual bool linearizationCovered(const Point& end, Scratch* scratch) const = 0;
};

/// The effect of that class; nullptr if the model has none.
template <typename E>
const E* find(const Model& model) {
  for (const auto& effect : model.effects) {
    if (const auto* found = dynamic_cast<const E*>(effect.get())) return found;
  }
  return nullptr;
}

/// The memory and the threads that a computation with a model needs. It serves one computation at a
/// time.
class Workspace {
 public:
  /// One effect, and what it can do besides; these are null if it cannot.
  struct Part {
    const Effect* effect;
    const DrivingEffect* driving;
    const SweptEffect* swept;
    const ForeseeingEffect* foreseeing;
    std::unique_ptr<Scratch> scratch;
  };

  /// @param threads  of another workspace that is no longer used; nullptr = its own
  explicit Workspace(const Model& model, std::shared_ptr<ThreadPool> threads = nullptr);
  ~Workspace();

  const Model& model() const { return model_; }
  ThreadPool& threads() { return *threads_; }
  const std::shared_ptr<ThreadPool>& sharedThreads() const { return threads_; }
  std::vector<Part>& parts() { return parts_; }

 private:
  const Model& model_;
  std::shared_ptr<ThreadPool> threads_;
  std::vector<Part> parts_;
};

/// Sum over the model's effects, and the external loads if there are any [N].
void sumForces(Workspace& workspace, const Vectors* loads, const Point& point, Vectors& forces);
/// The same with what else is wanted; forces must be.
void sumForces(Workspace& workspace, const Vectors* loads, const Point& point, const Sums& sums);

/// Adds the energy of the effects [J].
/// @param without  the effect to leave out, or nullptr
void addEnergy(Workspace& workspace, const Point& point, const Effect* without, Energy& energy);

/// See Effect.
void addForceDerivative(Workspace& workspace, const Point& point, const Vectors& dx,
                        const Vectors& dv, Vectors& df);

/// Is there an effect that depends on time, then or later?
bool dependsOnTime(Workspace& workspace, const Point& point);

void beginSubstep(Workspace& workspace, const Vectors& positions, const Vectors& velocities,
                  double h);
/// @return whether something has passed through something else
bool endSubstep(Workspace& workspace, const Vectors& positions);

}  // namespace mass_spring
