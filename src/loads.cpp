#include "loads.h"

#include <algorithm>

namespace mass_spring {

void Loads::add(const std::string& id, std::vector<std::uint32_t> particles,
                std::vector<Eigen::Vector3d> forces, std::uint64_t steps) {
  if (!id.empty()) {
    loads_.erase(std::remove_if(loads_.begin(), loads_.end(),
                                [&](const Load& load) { return load.id == id; }),
                 loads_.end());
  }
  loads_.push_back({id, std::move(particles), std::move(forces), steps});
  sum();
}

void Loads::clear() { loads_.clear(); }

void Loads::advance() {
  bool expired = false;
  for (Load& load : loads_) {
    if (load.steps_left != kUntilCleared && --load.steps_left == 0) expired = true;
  }
  if (!expired) return;
  loads_.erase(std::remove_if(loads_.begin(), loads_.end(),
                              [](const Load& load) { return load.steps_left == 0; }),
               loads_.end());
  sum();
}

void Loads::sum() {
  // Summed anew each time, so that nothing is left over of a load that has gone.
  total_.setZero(3, particle_count_);
  for (const Load& load : loads_) {
    for (std::size_t k = 0; k < load.particles.size(); ++k) {
      total_.col(load.particles[k]) += load.forces[load.forces.size() == 1 ? 0 : k];
    }
  }
}

}  // namespace mass_spring
