#pragma once

#include <map>
#include <string>
#include <vector>

#include "mass_spring_sim/command.h"
#include "mass_spring_sim/model.h"
#include "mass_spring_sim/state.h"

namespace mass_spring {

/// Particles whose position is prescribed: they move rigidly with the pin's target pose.
struct Pin {
  std::vector<std::uint32_t> particles;  ///< global
  std::vector<Eigen::Vector3d> offsets;  ///< m, in the frame of the target pose
  Pose target;                           ///< in the scene's frame
  std::string follow_frame;              ///< tf frame that leads it; "" = led by commands
};

/// The pins of a simulation, by name. A particle belongs to at most one pin.
class Pins {
 public:
  explicit Pins(std::uint32_t particle_count);

  /// @param command    validated by the caller, except for conflicts with other pins
  /// @param object     to which the particles belong
  /// @param particles  global, of this one object, not empty
  /// @param positions  of all particles [m]
  CommandResult add(const PinCommand& command, const ModelObject& object,
                    std::vector<std::uint32_t> particles, const Vectors& positions);
  CommandResult move(const PinCommand& command);
  CommandResult remove(const std::string& name);
  void clear();

  const std::map<std::string, Pin>& all() const { return pins_; }
  bool empty() const { return pins_.empty(); }
  /// Per particle: is it pinned?
  const std::vector<char>& mask() const { return mask_; }
  /// Writes the prescribed positions of pinned particles [m]; leaves the others alone.
  void prescribe(Vectors& positions) const;

 private:
  CommandResult unknown(const std::string& name) const;

  std::map<std::string, Pin> pins_;
  std::vector<char> mask_;
};

}  // namespace mass_spring
