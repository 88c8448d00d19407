#include "tools/closed_form.h"

#include <cmath>
#include <complex>

#include "mass_spring_sim/simulation.h"

namespace mass_spring {
namespace {

struct Motion {
  double position, velocity;
};

/// y'' + 2 d y' + w^2 y = 0 from a start, w > 0.
Motion oscillate(double d, double w, const Motion& start, double t) {
  using Complex = std::complex<double>;
  const Complex root = std::sqrt(Complex(d * d - w * w, 0.0));
  if (std::abs(root) < 1e-9 * w) {  // critical
    const double b = start.velocity + d * start.position;
    const double decay = std::exp(-d * t);
    return {(start.position + b * t) * decay, (b - d * (start.position + b * t)) * decay};
  }
  const Complex r1 = -d + root, r2 = -d - root;
  const Complex a1 = (start.velocity - r2 * start.position) / (r1 - r2);
  const Complex a2 = start.position - a1;
  const Complex e1 = a1 * std::exp(r1 * t), e2 = a2 * std::exp(r2 * t);
  return {(e1 + e2).real(), (r1 * e1 + r2 * e2).real()};
}

/// The free particle of a spring whose other end is pinned; lengths and speeds along `axis`.
struct Oscillator {
  Eigen::Vector3d anchor, axis;
  double rest_place;  ///< m, length at rest under gravity
  double d, w;        ///< 1/s
  Motion start;       ///< from there

  /// Bound of the way to either side: the energy, which only falls, bounds it.
  double reach() const { return std::hypot(start.position, start.velocity / w); }
};

}  // namespace

std::optional<std::vector<State>> closedForm(const Scene& scene, const std::vector<double>& times) {
  if (!scene.timeline.empty()) return std::nullopt;
  const Simulation simulation(scene);
  const Model& model = simulation.model();
  for (const std::string& effect : model.effectNames()) {
    if (effect != "springs" && effect != "spring_damping" && effect != "gravity") {
      return std::nullopt;
    }
  }
  const std::vector<char>& pinned = simulation.pins().mask();
  const Eigen::Vector3d gravity =
      scene.effects.gravity ? scene.effects.gravity->acceleration : Eigen::Vector3d::Zero();
  std::vector<const Spring*> held(model.particleCount(), nullptr);
  for (const Spring& spring : model.springs) {
    if (pinned[spring.i] && pinned[spring.j]) continue;
    if (!pinned[spring.i] && !pinned[spring.j]) return std::nullopt;
    const Spring*& mine = held[pinned[spring.i] ? spring.j : spring.i];
    if (mine != nullptr) return std::nullopt;
    mine = &spring;
  }
  std::vector<std::optional<Oscillator>> oscillators(model.particleCount());
  for (std::uint32_t i = 0; i < model.particleCount(); ++i) {
    if (pinned[i] || held[i] == nullptr) continue;
    const Spring& spring = *held[i];
    Oscillator o;
    o.anchor = model.start.positions.col(spring.i == i ? spring.j : spring.i);
    const Eigen::Vector3d offset = model.start.positions.col(i) - o.anchor;
    const Eigen::Vector3d speed = model.start.velocities.col(i);
    const double length = offset.norm();
    if (!(length > 0.0) || spring.stiffness == 0.0) return std::nullopt;
    o.axis = offset / length;
    if (o.axis.cross(gravity).norm() > 1e-12 * gravity.norm() ||
        o.axis.cross(speed).norm() > 1e-12 * speed.norm()) {
      return std::nullopt;
    }
    o.w = std::sqrt(spring.stiffness / model.masses[i]);
    o.d = 0.5 * spring.damping / model.masses[i];
    o.rest_place = spring.rest_length + o.axis.dot(gravity) / (o.w * o.w);
    o.start = {length - o.rest_place, o.axis.dot(speed)};
    if (!(o.reach() < o.rest_place)) return std::nullopt;
    oscillators[i] = o;
  }
  std::vector<State> states;
  for (const double t : times) {
    State state = model.start;
    state.time = t;
    for (std::uint32_t i = 0; i < model.particleCount(); ++i) {
      if (pinned[i]) continue;
      if (oscillators[i]) {
        const Oscillator& o = *oscillators[i];
        const Motion motion = oscillate(o.d, o.w, o.start, t);
        state.positions.col(i) = o.anchor + (o.rest_place + motion.position) * o.axis;
        state.velocities.col(i) = motion.velocity * o.axis;
      } else {
        state.positions.col(i) += t * (state.velocities.col(i) + 0.5 * t * gravity);
        state.velocities.col(i) += t * gravity;
      }
    }
    states.push_back(state);
  }
  return states;
}

}  // namespace mass_spring
