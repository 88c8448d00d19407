#pragma once

#include <functional>
#include <vector>

#include "effects/effect.h"
#include "schemes/drive.h"
#include "solvers/linear_system.h"

namespace mass_spring {

/// The linear systems of the implicit schemes, all of them with a matrix M + w D + w^2 K for some
/// w [s] (course notes eq. 19 with w = h). Pinned particles are no unknowns: their columns of a
/// solution keep what a start holds, and right-hand sides must be zero there.
class StepSystem {
 public:
  /// @param part  is an effect of the model to be in its matrix?
  StepSystem(Workspace& workspace, const SolverOptions& options,
             const std::function<bool(const Effect&)>& part);
  /// With all effects of the model.
  StepSystem(Workspace& workspace, const SolverOptions& options);

  /// The matrix with K and D at a point, coupled still with the pinned particles.
  /// @param damping_positions  for D, in place of those of the point; nullptr = the same
  void assemble(double w, const Point& point, const Vectors* damping_positions,
                Projection projection, SubstepReport& report);
  /// The matrix of a linearly implicit step of w [s], and the forces in it without loads.
  void linearize(double w, const Point& point, Vectors& forces, SubstepReport& report);
  /// Did the last linearize() see coming what is where the step ends?
  bool linearizationCovered(const Point& end);
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
  Workspace& workspace_;
  std::vector<const Workspace::Part*> parts_;
  StepMatrix matrix_;
  LinearSystem system_;
};

/// The columns of pinned particles become zero.
void clearPinned(const Drive& drive, Vectors& a);
/// Over the free particles; 0 if there are none.
double rootMeanSquare(const Drive& drive, const Vectors& a);

}  // namespace mass_spring
