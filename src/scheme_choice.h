#pragma once

#include <string>

#include "mass_spring_sim/model.h"
#include "mass_spring_sim/scene.h"

namespace mass_spring {

/// Of whatever brings a bound on a spectrum down; more gain next to nothing.
constexpr int kPowerIterations = 30;

/// Upper bounds of what springs and effects of a model can do at any positions.
struct SpectrumBounds {
  double frequency;  ///< rad/s, sqrt of the largest eigenvalue of M^-1 K
  double damping;    ///< 1/s, largest eigenvalue of M^-1 D
};
/// K lies below the Laplacian of the springs, L (x) I, since r = 1 - l0/l < 1; and the spectral
/// radius of M^-1 |L| is at most max_i (M^-1 |L| y)_i / y_i for every y > 0 (Collatz 1942), which a
/// few power iterations bring down. What effects do to particles alone is added on the diagonal.
SpectrumBounds boundSpectrum(const Model& model);

/// The largest stable step [s] of symplectic Euler: w^2 h^2 + 2 d h <= 4; infinity where nothing
/// acts.
double stableSymplecticStep(const SpectrumBounds& bounds);
/// Of Stoermer-Verlet with velocities continued for the damping: w^2 h^2 + 4 d h <= 4.
double stableVerletStep(const SpectrumBounds& bounds);
/// Of rk4: within an ellipse inside its region of stability, (h w / 2.8)^2 + h d / 2.7 <= 1.
double stableRk4Step(const SpectrumBounds& bounds);

struct SchemeChoice {
  SolverOptions options;  ///< with a scheme that is not auto, and the sub-steps it needs
  std::string reason;     ///< for the user; empty if there was nothing to choose
};
/// Decides `auto`: an explicit scheme in so many sub-steps that it is stable, or an implicit one,
/// whichever costs less on this model, with the sub-steps that an accuracy is likely to need.
/// @param model  with its springs and effects
SchemeChoice chooseScheme(const Scene& scene, const Model& model);

}  // namespace mass_spring
