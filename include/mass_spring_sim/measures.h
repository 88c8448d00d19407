#pragma once

#include <map>
#include <optional>
#include <string>

#include "mass_spring_sim/model.h"
#include "mass_spring_sim/pins.h"
#include "mass_spring_sim/state.h"

namespace mass_spring {

struct Energy {
  double kinetic = 0.0;  ///< J
  double elastic = 0.0;  ///< J, springs (course notes eq. 5)
  double gravity = 0.0;  ///< J, 0 at the origin of the scene's frame
  double total() const { return kinetic + elastic + gravity; }
};

class Workspace;

/// Makes a workspace for each call. A simulation, which has one, has the same measures.
Energy energy(const Model& model, const State& state);
Energy energy(Workspace& workspace, const State& state);

/// Largest speed of a particle [m/s].
double maxSpeed(const State& state);

/// Largest length / rest length as built over the springs with such a length above 0; 0 if there
/// are none.
double maxStretch(const Model& model, const State& state);

/// Strain l / L - 1 of one spring (length l, rest length L); 0 where L = 0.
double strain(const Spring& spring, const Vectors& positions);

/// Force and torque of particles on a pin or shape, in the axes of the scene.
struct Wrench {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   ///< N
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();  ///< N m

  void add(const Eigen::Vector3d& f, const Eigen::Vector3d& arm) {
    force += f;
    torque += arm.cross(f);
  }
};

/// The wrench of the particles of each pin on the holder, about the origin of the pin's target: all
/// forces on the particles. The inertia of the particles themselves is not included while the pin
/// is accelerated. At rest, the forces of all pins add up to the weight.
/// @param workspace  of the model
/// @param state      at which the forces are taken
/// @param pins       that hold the particles
/// @param loads      forces of commands [N per particle], or nullptr
std::map<std::string, Wrench> pinWrenches(Workspace& workspace, const State& state,
                                          const Pins& pins, const Vectors* loads);

/// The wrench of the particles on each shape of contact, about its center (a plane's point), as a
/// sensor in the shape would measure it. Empty without contact.
std::map<std::string, Wrench> shapeWrenches(Workspace& workspace, const State& state);

/// The contact of one particle with one shape.
struct Touch {
  std::uint32_t particle;
  std::uint32_t shape;    ///< index in the bytewise order of names
  Eigen::Vector3d force;  ///< N, on the particle
};

/// All contacts, particle by particle; empty without contact.
std::vector<Touch> touches(Workspace& workspace, const State& state);

/// The first particle whose position or velocity is not finite.
std::optional<std::uint32_t> firstNotFinite(const State& state);

}  // namespace mass_spring
