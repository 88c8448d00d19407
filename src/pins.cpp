#include "mass_spring_sim/pins.h"

namespace mass_spring {

Pins::Pins(std::uint32_t particle_count) : mask_(particle_count, 0) {}

CommandResult Pins::add(const PinCommand& command, const ModelObject& object,
                        std::vector<std::uint32_t> particles, const Vectors& positions) {
  if (pins_.count(command.name) > 0) {
    return {Refusal::kConflict, "name: a pin '" + command.name + "' exists"};
  }
  for (std::uint32_t particle : particles) {
    if (!mask_[particle]) continue;
    for (const auto& [name, pin] : pins_) {
      for (std::uint32_t held : pin.particles) {
        if (held == particle) {
          return {Refusal::kConflict, "particles: pin '" + name + "' holds particle " +
                                          std::to_string(particle - object.first_particle) +
                                          " of " + object.name};
        }
      }
    }
  }
  Pin pin;
  pin.target = command.target;
  pin.follow_frame = command.follow_frame;
  if (command.here) {
    pin.target = Pose();
    for (std::uint32_t particle : particles) pin.target.position += positions.col(particle);
    pin.target.position /= static_cast<double>(particles.size());
  }
  const Eigen::Quaterniond to_pin = pin.target.orientation.conjugate();
  for (std::uint32_t particle : particles) {
    pin.offsets.push_back(to_pin * (positions.col(particle) - pin.target.position));
    mask_[particle] = 1;
  }
  pin.particles = std::move(particles);
  pins_.emplace(command.name, std::move(pin));
  return {};
}

CommandResult Pins::move(const PinCommand& command) {
  const auto found = pins_.find(command.name);
  if (found == pins_.end()) return unknown(command.name);
  Pin& pin = found->second;
  if (pin.follow_frame != command.follow_frame) {
    return {Refusal::kConflict,
            "name: pin '" + command.name + "' follows " +
                (pin.follow_frame.empty() ? "no frame, not '" : "the frame '") +
                (pin.follow_frame.empty() ? command.follow_frame : pin.follow_frame) + "'"};
  }
  pin.target = command.target;
  return {};
}

CommandResult Pins::remove(const std::string& name) {
  const auto found = pins_.find(name);
  if (found == pins_.end()) return unknown(name);
  for (std::uint32_t particle : found->second.particles) mask_[particle] = 0;
  pins_.erase(found);
  return {};
}

CommandResult Pins::unknown(const std::string& name) const {
  std::string known;
  for (const auto& [other, pin] : pins_) known += (known.empty() ? "" : ", ") + other;
  return {Refusal::kUnknownPin, "name: got '" + name + "', expected one of the pins there are: " +
                                    (known.empty() ? "none" : known)};
}

void Pins::clear() {
  pins_.clear();
  mask_.assign(mask_.size(), 0);
}

void Pins::prescribe(Vectors& positions) const {
  for (const auto& [name, pin] : pins_) {
    for (std::size_t k = 0; k < pin.particles.size(); ++k) {
      positions.col(pin.particles[k]) =
          pin.target.position + pin.target.orientation * pin.offsets[k];
    }
  }
}

}  // namespace mass_spring
