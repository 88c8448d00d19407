#include "mass_spring_sim/measures.h"

#include <algorithm>
#include <cmath>

#include "effects/contact.h"
#include "effects/effect.h"

namespace mass_spring {

Energy energy(const Model& model, const State& state) {
  Energy energy;
  setTime(model, state.time);
  energy.kinetic = 0.5 * state.velocities.colwise().squaredNorm().dot(model.masses.transpose());
  for (const auto& effect : model.effects) effect->addEnergy(state.positions, energy);
  return energy;
}

double maxSpeed(const State& state) {
  if (state.velocities.cols() == 0) return 0.0;
  return std::sqrt(state.velocities.colwise().squaredNorm().maxCoeff());
}

double maxStretch(const Model& model, const State& state) {
  double largest = 0.0;
  for (const Spring& s : model.springs) {
    if (s.rest_length > 0.0) largest = std::max(largest, 1.0 + strain(s, state.positions));
  }
  return largest;
}

double strain(const Spring& spring, const Vectors& positions) {
  if (spring.rest_length == 0.0) return 0.0;
  return (positions.col(spring.j) - positions.col(spring.i)).norm() / spring.rest_length - 1.0;
}

std::map<std::string, Wrench> pinWrenches(const Model& model, const State& state, const Pins& pins,
                                          const Vectors* loads) {
  std::map<std::string, Wrench> wrenches;
  if (pins.empty()) return wrenches;
  Vectors forces(3, state.positions.cols());
  setTime(model, state.time);
  sumForces(model, loads, state.positions, state.velocities, forces);
  for (const auto& [name, pin] : pins.all()) {
    Wrench& wrench = wrenches[name];
    for (const std::uint32_t i : pin.particles) {
      wrench.add(forces.col(i), state.positions.col(i) - pin.target.position);
    }
  }
  return wrenches;
}

std::map<std::string, Wrench> shapeWrenches(const Model& model, const State& state) {
  std::map<std::string, Wrench> wrenches;
  if (model.contact == nullptr) return wrenches;
  for (const Shape& shape : model.contact->shapes()) wrenches[shape.name()];
  for (const Touch& touch : touches(model, state)) {
    const Shape& shape = model.contact->shapes()[touch.shape];
    wrenches[shape.name()].add(-touch.force,
                               state.positions.col(touch.particle) - shape.pose().position);
  }
  return wrenches;
}

std::vector<Touch> touches(const Model& model, const State& state) {
  if (model.contact == nullptr) return {};
  setTime(model, state.time);
  return model.contact->touches(state.positions, state.velocities);
}

std::optional<std::uint32_t> firstNotFinite(const State& state) {
  for (Eigen::Index i = 0; i < state.positions.cols(); ++i) {
    if (!state.positions.col(i).allFinite() || !state.velocities.col(i).allFinite()) {
      return static_cast<std::uint32_t>(i);
    }
  }
  return std::nullopt;
}

}  // namespace mass_spring
