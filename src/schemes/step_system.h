#pragma once

#include <vector>

#include "effects/effect.h"
#include "mass_spring_sim/model.h"
#include "schemes/drive.h"
#include "solvers/linear_system.h"

namespace mass_spring {

/// The linear systems of the implicit schemes, all of them with a matrix M + w D + w^2 K for some
/// w [s] (course notes eq. 19 with w = h). Pinned particles are no unknowns: their columns of a
/// solution keep what a start holds, and right-hand sides must be zero there.
class StepSystem {
 public:
  /// @param effects  the only ones to be in its matrix
  StepSystem(const Model& model, const SolverOptions& options, std::vector<const Effect*> effects);
  /// With all effects of the model.
  StepSystem(const Model& model, const SolverOptions& options);

  /// The matrix with K at positions x and D at positions x_damping, both at velocities v, coupled
  /// still with the pinned particles.
  void assemble(double w, const Vectors& x, const Vectors& x_damping, const Vectors& v,
                Projection projection, SubstepReport& report);
  /// The matrix of a linearly implicit step of w [s], and the forces in it without loads.
  void linearize(double w, const State& state, Vectors& forces, SubstepReport& report);
  /// y = A x, before decouple().
  void multiply(const Vectors& x, Vectors& y) const { matrix_.multiply(x, y); }
  /// Takes the pinned particles out of the matrix, which is then ready to be solved with.
  void decouple(const std::vector<char>& pinned);
  /// Makes the matrix heavier, after decouple(): see StepMatrix::shift().
  void shift(double share);
  /// Adds a share of the masses, after decouple().
  void addMasses(double share, SubstepReport& report);
  /// A x = b to |b - A x| <= tolerance |b|, from the x given where that helps.
  LinearSystem::Result solve(const Vectors& b, double tolerance, Vectors& x, SubstepReport& report);

  /// Forgets what earlier matrices taught the solver.
  void restart() { system_.restart(); }
  std::size_t nonzeros() const { return matrix_.pattern().nonzeros(); }

 private:
  const Model& model_;
  std::vector<const Effect*> effects_;
  StepMatrix matrix_;
  LinearSystem system_;
};

/// The columns of pinned particles become zero.
void clearPinned(const Drive& drive, Vectors& a);
/// Over the free particles; 0 if there are none.
double rootMeanSquare(const Drive& drive, const Vectors& a);

}  // namespace mass_spring
