#include "scene/references.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <unordered_set>

#include "mass_spring_sim/scene.h"
#include "scene/scalar.h"

namespace mass_spring {

bool readObjectName(const Place& place, const ParticleCounts& counts, std::string& name) {
  std::vector<std::string> names;
  for (const auto& [known, count] : counts) names.push_back(known);
  if (!place.present() && names.size() == 1) {
    name = names.front();
    return true;
  }
  if (!place.present()) {
    place.refuse("one of " + listWords(names));
    return false;
  }
  std::size_t index = 0;
  if (!place.read(index, names)) return false;
  name = names[index];
  return true;
}

bool isModerate(const Place& place, double number, const std::string& unit) {
  if (std::abs(number) <= kLargestCoordinate) return true;
  place.report(formatNumber(number) + ' ' + unit,
               "at most " + formatNumber(kLargestCoordinate) + ' ' + unit);
  return false;
}

bool readPosition(const Place& place, Eigen::Vector3d& position) {
  return place.read(position, anyNumber("m")) &&
         isModerate(place, position.cwiseAbs().maxCoeff(), "m");
}

void readFrame(const Place& place, std::string& frame_id) {
  const std::string expected = "the name of a frame, without leading slash or blanks";
  if (!place.read(frame_id, expected)) return;
  const bool blank = std::any_of(frame_id.begin(), frame_id.end(),
                                 [](unsigned char c) { return c <= ' ' || c == 0x7f; });
  if (frame_id.empty() || frame_id[0] == '/' || blank) place.refuse(expected);
}

bool readParticles(const Place& place, std::optional<std::uint32_t> count,
                   std::vector<std::uint32_t>& particles) {
  const Tree::List* list = place.list("a list of particle indices");
  if (list == nullptr) return false;
  const int highest = count ? static_cast<int>(*count) - 1 : std::numeric_limits<int>::max();
  std::unordered_set<int> seen;
  bool good = true;
  for (std::size_t i = 0; i < list->size(); ++i) {
    const Place element = place.element(i);
    int index = 0;
    if (!element.read(index, 0, highest)) {
      good = false;
    } else if (!seen.insert(index).second) {
      element.report(std::to_string(index) + " again", "each particle once");
      good = false;
    } else {
      particles.push_back(static_cast<std::uint32_t>(index));
    }
  }
  return good;
}

void PinLedger::add(const std::string& pin, const std::string& object,
                    const std::vector<std::uint32_t>& particles, const Place& place) {
  names_.insert(pin);
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const auto [holder, free] = holders_.emplace(std::pair(object, particles[i]), pin);
    if (free) continue;
    place.element(i).refuse("a particle that no other pin holds (" + quote(holder->second) +
                            " holds it)");
  }
}

void PinLedger::remove(const std::string& pin) {
  names_.erase(pin);
  for (auto holder = holders_.begin(); holder != holders_.end();) {
    holder = holder->second == pin ? holders_.erase(holder) : std::next(holder);
  }
}

}  // namespace mass_spring
