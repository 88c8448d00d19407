#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mass_spring_sim/model.h"
#include "solvers/interpolation.h"
#include "solvers/net_coarsening.h"

namespace mass_spring {

/// The arrangement of a model's particles at rest, as far as a multigrid must know it, and how it
/// is thinned out level by level. Every object is thinned by itself; particles that are coupled
/// with no other do not reach the next level.
class RestShape {
 public:
  explicit RestShape(const Model& model);

  /// The interpolation from the next coarser level, to which this shape turns.
  Interpolation coarsen();

 private:
  using Axes = std::array<std::vector<double>, 3>;  // coordinates of a grid's particles
  /// One object: a grid if it has axes, else a net.
  struct Body {
    bool coupled;
    Axes axes;
    Net net;
  };
  static Net netOf(const Model& model, const ModelObject& object);
  static Interpolation coarsenGrid(Axes& axes);

  std::vector<Body> bodies_;
};

}  // namespace mass_spring
