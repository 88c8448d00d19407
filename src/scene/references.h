#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "scene/tree_reader.h"

namespace mass_spring {

/// Particles of each object of a scene; nothing for an object that has problems of its own, so that
/// its particles cannot be checked.
using ParticleCounts = std::map<std::string, std::optional<std::uint32_t>>;

/// The name of an object. May be absent where the place is not required and the scene has just one
/// object, whose name it then reads.
bool readObjectName(const Place& place, const ParticleCounts& counts, std::string& name);

/// Reports a number whose size is more than kLargestCoordinate. @return whether it is not
bool isModerate(const Place& place, double number, const std::string& unit);
/// Coordinates of a place in the scene.
bool readPosition(const Place& place, Eigen::Vector3d& position);
/// One length or more of something in the scene, > 0.
template <typename Size>
bool readSize(const Place& place, Size& size) {
  if (!place.read(size, positive("m"))) return false;
  if constexpr (std::is_same_v<Size, double>) {
    return isModerate(place, size, "m");
  } else {
    return isModerate(place, size.maxCoeff(), "m");
  }
}

/// The name of a tf frame.
void readFrame(const Place& place, std::string& frame_id);

/// Particle indices of one object, none twice; their range is checked if the count is known.
bool readParticles(const Place& place, std::optional<std::uint32_t> count,
                   std::vector<std::uint32_t>& particles);

/// The pins there are, and which particles they hold: each is held by one pin at the most.
class PinLedger {
 public:
  /// Reports those particles that another pin holds already.
  /// @param place  of the list of particles
  void add(const std::string& pin, const std::string& object,
           const std::vector<std::uint32_t>& particles, const Place& place);
  void remove(const std::string& pin);
  const std::set<std::string>& names() const { return names_; }

 private:
  std::set<std::string> names_;
  std::map<std::pair<std::string, std::uint32_t>, std::string> holders_;
};

}  // namespace mass_spring
