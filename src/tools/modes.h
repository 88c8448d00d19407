#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mass_spring_sim/scene.h"
#include "tools/reference.h"

namespace mass_spring {

/// One damped oscillation, as it is seen.
struct Oscillation {
  double frequency = 0.0;  ///< Hz, at which it swings; 0 if it only decays
  double damping = 0.0;    ///< ratio to the critical damping; negative if it grows
  double misfit = 0.0;     ///< what is not explained by it, over what there is (root mean squares)
};

/// The oscillation about some mean that samples follow best.
/// @param samples   equally spaced
/// @param interval  s, between them
/// @param stride    samples from one that is used to the next; less than half a period
/// @return nullopt if they are too few, or do not tell
std::optional<Oscillation> fitOscillation(const std::vector<double>& samples, double interval,
                                          std::size_t stride);

/// A mode of the linearized scene that swings visibly.
struct Mode {
  Vectors weights;     ///< their scalar product with the positions is its amplitude
  std::size_t stride;  ///< frames, for fitOscillation()
  double share;        ///< of the energy of all modes
  Oscillation linear;  ///< by the linearized scene
  Oscillation truth;   ///< of the reference

  double amplitude(const Vectors& positions) const { return weights.cwiseProduct(positions).sum(); }
};

/// The motion near a shape at rest.
struct Modes {
  std::vector<Mode> modes;  ///< slow first
  std::string reason;       ///< why there are none
  std::size_t first = 0;    ///< frame from which on the scene is near that shape
};

/// The slowest modes that carry notable energy, of scenes that stay near a shape at rest, or come
/// near it, and whose linearization predicts the reference.
/// @param frame_rate  Hz, of the reference's frames
/// @param frames      of them, from the first, that may be used
Modes findModes(const Scene& scene, const Reference& reference, double frame_rate,
                std::size_t frames);

/// The largest errors over some modes.
struct ModeErrors {
  double frequency = 0.0;  ///< relative
  double damping = 0.0;    ///< of the damping ratio, absolute
};
/// @param amplitudes  per mode, per frame from modes.first on
ModeErrors compare(const Modes& modes, const std::vector<std::vector<double>>& amplitudes,
                   double frame_rate);

}  // namespace mass_spring
