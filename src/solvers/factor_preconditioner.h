#pragma once

#include "solvers/direct_solver.h"
#include "solvers/preconditioner.h"

namespace mass_spring {

/// A direct factor where it is not the inverse of all that a matrix does: of a matrix without its
/// ties. The factor is made by whoever owns it.
class FactorPreconditioner : public Preconditioner {
 public:
  FactorPreconditioner(DirectSolver& factor, std::uint32_t size)
      : factor_(factor), r_(3, size), z_(3, size) {}
  bool prepare(const StepMatrix& /*matrix*/) override { return true; }
  void apply(const FloatVectors& r, FloatVectors& z, FloatVectors& /*work*/) override {
    r_ = r.topRows<3>().cast<double>();
    factor_.solve(r_, z_);
    z.topRows<3>() = z_.cast<float>();
  }

 private:
  DirectSolver& factor_;
  Vectors r_, z_;
};

}  // namespace mass_spring
