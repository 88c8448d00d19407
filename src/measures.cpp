#include "mass_spring_sim/measures.h"

#include <algorithm>
#include <cmath>

#include "effects/contact.h"
#include "effects/effect.h"
#include "thread_pool.h"

namespace mass_spring {

namespace {

Point pointAt(const State& state) {
  return {state.positions, state.velocities, state.time, state.effects};
}

}  // namespace

Energy energy(const Model& model, const State& state) {
  Workspace workspace(model, std::make_shared<ThreadPool>(1));
  return energy(workspace, state);
}

Energy energy(Workspace& workspace, const State& state) {
  Energy energy;
  energy.kinetic =
      0.5 * state.velocities.colwise().squaredNorm().dot(workspace.model().masses.transpose());
  addEnergy(workspace, pointAt(state), nullptr, energy);
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

std::map<std::string, Wrench> pinWrenches(Workspace& workspace, const State& state,
                                          const Pins& pins, const Vectors* loads) {
  std::map<std::string, Wrench> wrenches;
  if (pins.empty()) return wrenches;
  Vectors forces(3, state.positions.cols());
  sumForces(workspace, loads, pointAt(state), forces);
  for (const auto& [name, pin] : pins.all()) {
    Wrench& wrench = wrenches[name];
    for (const std::uint32_t i : pin.particles) {
      wrench.add(forces.col(i), state.positions.col(i) - pin.target.position);
    }
  }
  return wrenches;
}

std::map<std::string, Wrench> shapeWrenches(Workspace& workspace, const State& state) {
  std::map<std::string, Wrench> wrenches;
  const std::vector<Shape>& shapes = workspace.model().shapes;
  for (const Shape& shape : shapes) wrenches[shape.name()];
  for (const Touch& touch : touches(workspace, state)) {
    const Eigen::Vector3d center = state.effects.shapes[touch.shape].at(state.time).position;
    wrenches[shapes[touch.shape].name()].add(-touch.force,
                                             state.positions.col(touch.particle) - center);
  }
  return wrenches;
}

std::vector<Touch> touches(Workspace& workspace, const State& state) {
  for (const Workspace::Part& part : workspace.parts()) {
    if (const auto* contact = dynamic_cast<const Contact*>(part.effect)) {
      return contact->touches(pointAt(state), part.scratch.get());
    }
  }
  return {};
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
