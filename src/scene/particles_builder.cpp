#include "object_parts.h"

namespace mass_spring {

ObjectParts buildParts(const Particles& particles) {
  const std::size_t count = particles.positions.size();
  ObjectParts parts;
  parts.positions.resize(3, static_cast<Eigen::Index>(count));
  parts.velocities.resize(3, static_cast<Eigen::Index>(count));
  for (std::size_t i = 0; i < count; ++i) {
    parts.positions.col(i) = particles.positions[i];
    parts.velocities.col(i) = particles.velocities[i];
  }
  parts.masses =
      Eigen::Map<const Eigen::VectorXd>(particles.masses.data(), static_cast<Eigen::Index>(count));
  for (std::size_t s = 0; s < particles.springs.size(); ++s) {
    const auto [i, j] = particles.springs[s];
    const double rest_length = particles.rest_lengths
                                   ? (*particles.rest_lengths)[s]
                                   : (particles.positions[j] - particles.positions[i]).norm();
    const double damping = particles.damping ? (*particles.damping)[s] : 0.0;
    parts.springs.push_back(
        {i, j, rest_length, particles.stiffness[s], damping, SpringKind::kStructural});
  }
  return parts;
}

}  // namespace mass_spring
