#include "schemes/error_filter.h"

namespace mass_spring {

ErrorFilter::ErrorFilter(Workspace& workspace, StepSystem& system)
    : workspace_(workspace), system_(system) {
  still_.setZero(3, workspace.model().particleCount());
  right_side_.setZero(3, workspace.model().particleCount());
}

double ErrorFilter::apply(double w, const Drive& drive, const Point& end, Vectors& positions,
                          Vectors& velocities, SubstepReport& report) {
  // x' - w v' = x, M v' + w D v' + w K x' = M v. With the unknown u = x' / w:
  // (M + w D + w^2 K) u = M (v + x / w) + D x, where D y = -(df/dv) y.
  right_side_.setZero();
  addForceDerivative(workspace_, end, still_, positions, right_side_);
  velocities += positions / w;
  right_side_ = velocities * workspace_.model().masses.asDiagonal() - right_side_;
  clearPinned(drive, right_side_);
  clearPinned(drive, positions);
  velocities.setZero();
  // A tenth of an estimate is exact enough.
  const LinearSystem::Result result = system_.solve(right_side_, 0.1, velocities, report);
  if (result.converged) positions = w * velocities;
  return rootMeanSquare(drive, positions);
}

}  // namespace mass_spring
