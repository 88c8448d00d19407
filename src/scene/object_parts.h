#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "mass_spring_sim/model.h"
#include "mass_spring_sim/scene.h"

namespace mass_spring {

/// What one object is built of. Springs and triangles count the object's own particles from 0;
/// springs come structural first, then shear, then bending.
struct ObjectParts {
  Vectors positions;       ///< m
  Vectors velocities;      ///< m/s, as many as positions
  Eigen::VectorXd masses;  ///< kg, as many as positions
  std::vector<Spring> springs;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Particles at rest that share a mass [kg] equally.
ObjectParts partsAtRest(Vectors positions, double mass);

/// One function per type of object; each is defined in the file named after it.
ObjectParts buildParts(const Rope& rope);
ObjectParts buildParts(const Cloth& cloth);
ObjectParts buildParts(const Lattice& lattice);
ObjectParts buildParts(const Mesh& mesh);
ObjectParts buildParts(const Particles& particles);

/// Rotation by roll, pitch, yaw [rad] about fixed axes: R = Rz(yaw) Ry(pitch) Rx(roll) (REP 103).
Eigen::Matrix3d rotation(const Eigen::Vector3d& roll_pitch_yaw);

}  // namespace mass_spring
