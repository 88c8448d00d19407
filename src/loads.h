#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mass_spring_sim/state.h"

namespace mass_spring {

/// The external forces that are active: each on some particles, for a number of steps.
class Loads {
 public:
  static constexpr std::uint64_t kUntilCleared = ~std::uint64_t{0};

  explicit Loads(std::uint32_t particle_count) : particle_count_(particle_count) {}

  /// @param id         a load of the same id is replaced; "" = its own each time
  /// @param particles  global numbers, empty = none
  /// @param forces     N; one for all or one per particle
  /// @param steps      >= 1, or kUntilCleared
  void add(const std::string& id, std::vector<std::uint32_t> particles,
           std::vector<Eigen::Vector3d> forces, std::uint64_t steps);
  void clear();
  /// One step has been made with the loads as they are.
  void advance();

  std::uint32_t active() const { return static_cast<std::uint32_t>(loads_.size()); }
  /// Sum per particle [N]; nullptr while there is none.
  const Vectors* total() const { return loads_.empty() ? nullptr : &total_; }

 private:
  struct Load {
    std::string id;
    std::vector<std::uint32_t> particles;
    std::vector<Eigen::Vector3d> forces;
    std::uint64_t steps_left;
  };
  void sum();

  std::uint32_t particle_count_;
  std::vector<Load> loads_;  // in order of arrival
  Vectors total_;
};

}  // namespace mass_spring
