#include "effects/self_collision.h"

#include <algorithm>

#include "solvers/step_matrix.h"

namespace mass_spring {
namespace {

// Sub-steps that are looked ahead for pairs, if all goes on as it is.
constexpr double kAhead = 2.0;
// Pairs of the same particle that push it at once, as far as bounds go.
constexpr double kPushesAtOnce = 4.0;
// In units of mass / step^2: as much as explicit schemes bear.
constexpr double kFirm = 0.1;

// In place of a distance.
constexpr double kUnknown = -1.0;

// Those round a particle of a sheet push together.
constexpr double kTrianglesRound = 6.0;

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// As hard as the springs that pull things into each other: at that stiffness, and at least the
/// rigidity EA = k L divided by the thickness, a strain of the springs presses by about as large a
/// share of the thickness. Where springs are slacker than a step could notice, what steps bear.
double defaultStiffness(const Model& model, Elements elements, double thickness, double rate) {
  const bool surface = elements == Elements::kParticleAndTriangle;
  std::vector<double> stiffnesses,
      masses(model.masses.data(), model.masses.data() + model.masses.size());
  for (const Spring& s : model.springs) {
    if (s.kind != SpringKind::kStructural || s.stiffness == 0.0) continue;
    if (model.objectOf(s.i).has_surface != surface) continue;
    stiffnesses.push_back(s.stiffness * std::max(1.0, s.rest_length / thickness));
  }
  const double all =
      std::max(median(std::move(stiffnesses)), kFirm * rate * rate * median(std::move(masses)));
  return surface ? all / kTrianglesRound : all;
}

}  // namespace

SelfCollision::SelfCollision(const SelfCollisionOptions& options, const Model& model, double rate)
    : thickness_(options.thickness),
      broad_(CollisionElements(model), options.thickness, *model.threads),
      beside_(model.particleCount(), 0) {
  for (const Elements e : {Elements::kParticleAndTriangle, Elements::kSegments}) {
    stiffness_[static_cast<std::size_t>(e)] =
        options.stiffness ? *options.stiffness
                          : defaultStiffness(model, e, options.thickness, rate);
  }
}

void SelfCollision::beginSubstep(const Vectors& positions, const Vectors& velocities, double h) {
  start_ = positions;
  under_way_ = true;
  expected_ = positions + h * velocities;
  start_strayed_ = broad_.strayed(positions);
  if (!broad_.covers(start_strayed_) || !broad_.covers(broad_.strayed(expected_))) {
    expected_ = positions + kAhead * h * velocities;
    refresh(expected_);
  }
  start_distances_.assign(broad_.pairs().size(), kUnknown);
}

bool SelfCollision::endSubstep(const Vectors& positions) {
  bool passed = false;
  if (positions.allFinite()) {
    findPushes(positions);
    for (const Push& push : pushes_) passed = passed || push.passed;
  }
  under_way_ = false;
  return passed;
}

double SelfCollision::distanceWithin(const ElementPair& pair, const Corners& x) const {
  const double least = leastDistance(pair.elements, x);
  return least < thickness_ ? proximity(pair.elements, x).distance : least;
}

void SelfCollision::refresh(const Vectors& positions) const {
  broad_.refresh(under_way_ ? start_ : positions, positions);
  start_strayed_ = 0.0;
  start_distances_.assign(broad_.pairs().size(), kUnknown);
}

double SelfCollision::startDistance(std::size_t pair) const {
  double& distance = start_distances_[pair];
  if (distance == kUnknown) {
    const ElementPair& p = broad_.pairs()[pair];
    distance = distanceWithin(p, p.corners(start_));
  }
  return distance;
}

double SelfCollision::cover(const Vectors& positions) const {
  double strayed = broad_.strayed(positions);
  if (!broad_.covers(strayed)) {
    refresh(positions);
    strayed = broad_.strayed(positions);
  }
  return thickness_ + 2.0 * (under_way_ ? std::max(strayed, start_strayed_) : strayed);
}

void SelfCollision::findPushes(const Vectors& positions) const {
  const double reach = cover(positions);
  pushes_.clear();
  bool any_passed = false;
  for (std::size_t p = 0; p < broad_.pairs().size(); ++p) {
    const ElementPair& pair = broad_.pairs()[p];
    if (pair.apart >= reach) continue;
    const Corners x = pair.corners(positions);
    bool passed = false;
    if (under_way_) {
      const Corners start = pair.corners(start_);
      const double approach = mostApproach(pair.elements, x - start);
      const double distance = startDistance(p);
      if (distance - approach >= thickness_) continue;
      passed = distance <= approach && firstTouch(pair.elements, start, x);
    }
    if (!passed && leastDistance(pair.elements, x) >= thickness_) continue;
    const Push push{&pair, proximity(pair.elements, x), passed};
    if (!(depth(push) > 0.0)) continue;
    pushes_.push_back(push);
    any_passed = any_passed || passed;
  }
  if (any_passed) dropBesidePassed(start_, positions);
}

void SelfCollision::dropBesidePassed(const Vectors& from, const Vectors& to) const {
  std::fill(beside_.begin(), beside_.end(), 0);
  for (const Push& push : pushes_) {
    if (!push.passed) continue;
    for (const std::uint32_t i : push.pair->particles) beside_[i] = 1;
  }
  const auto misled = [&](const Push& push) {
    const auto& particles = push.pair->particles;
    return !push.passed && std::any_of(particles.begin(), particles.end(), [&](std::uint32_t i) {
      return beside_[i];
    }) && changesSides(push.pair->corners(from), push.pair->corners(to));
  };
  pushes_.erase(std::remove_if(pushes_.begin(), pushes_.end(), misled), pushes_.end());
}

void SelfCollision::spread(const Push& push, const Eigen::Vector3d& force, Vectors& vectors) {
  for (int a = 0; a < 4; ++a) {
    vectors.col(push.pair->particles[static_cast<std::size_t>(a)]) += push.near.weights[a] * force;
  }
}

void SelfCollision::addEnergy(const Vectors& positions, Energy& energy) const {
  const double reach = cover(positions);
  for (const ElementPair& pair : broad_.pairs()) {
    if (pair.apart >= reach) continue;
    const double depth = thickness_ - distanceWithin(pair, pair.corners(positions));
    if (depth > 0.0) energy.elastic += 0.5 * stiffness(pair) * depth * depth;
  }
}

void SelfCollision::addForces(const Vectors& positions, const Vectors& velocities,
                              Vectors& forces) const {
  Energy energy;
  double dissipation = 0.0;
  addForces(positions, velocities, forces, energy, dissipation);
}

void SelfCollision::addForces(const Vectors& positions, const Vectors& /*velocities*/,
                              Vectors& forces, Energy& energy, double& /*dissipation*/) const {
  findPushes(positions);
  for (const Push& push : pushes_) {
    energy.elastic += 0.5 * stiffness(*push.pair) * depth(push) * depth(push);
    spread(push, stiffness(*push.pair) * depth(push) * push.side() * push.near.normal, forces);
  }
}

// With G = side normal weights^T: df = -k dg G + k depth dG, dg = G . dx.
void SelfCollision::addForceDerivative(const Vectors& x, const Vectors& /*v*/, const Vectors& dx,
                                       const Vectors& /*dv*/, Vectors& df) const {
  findPushes(x);
  for (const Push& push : pushes_) {
    const Proximity& near = push.near;
    const Corners changed = push.pair->corners(dx);
    const ProximityRate turned = rate(near, push.pair->corners(x), changed);
    const double pressure = stiffness(*push.pair) * depth(push) * push.side();
    const double more = -stiffness(*push.pair) * near.normal.dot(changed * near.weights);
    spread(push, more * near.normal + pressure * turned.normal, df);
    for (int a = 0; a < 4; ++a) {
      df.col(push.pair->particles[static_cast<std::size_t>(a)]) +=
          pressure * turned.weights[a] * near.normal;
    }
  }
}

std::uint32_t SelfCollision::addDerivatives(const Vectors& positions, const Vectors& /*velocities*/,
                                            const MatrixWeights& weights, Projection projection,
                                            StepMatrix& matrix) const {
  if (weights.stiffness == 0.0) return 0;
  findPushes(positions);
  for (const Push& push : pushes_) {
    matrix.addTie({push.pair->particles, push.near.weights, push.near.normal,
                   weights.stiffness * stiffness(*push.pair)});
  }
  return projection == Projection::kNone ? 0 : static_cast<std::uint32_t>(pushes_.size());
}

std::uint32_t SelfCollision::linearize(const Vectors& positions, const Vectors& velocities,
                                       double w, StepMatrix& matrix, Vectors& forces) const {
  expected_ = positions + w * velocities;
  double reach = cover(expected_);
  if (!under_way_) reach = std::max(reach, cover(positions));
  pushes_.clear();
  bool any_passed = false;
  for (std::size_t p = 0; p < broad_.pairs().size(); ++p) {
    const ElementPair& pair = broad_.pairs()[p];
    if (pair.apart >= reach) continue;
    const Corners now = pair.corners(positions), then = pair.corners(expected_);
    const double distance = under_way_ ? startDistance(p) : distanceWithin(pair, now);
    const double approach = mostApproach(pair.elements, then - now);
    if (distance - approach >= thickness_) continue;
    // What is pushed out does not fall back in: the nearer one of what is and what is to come.
    std::optional<Proximity> near =
        distance <= approach ? firstTouch(pair.elements, now, then) : std::nullopt;
    const bool touches = near.has_value();
    if (!touches && leastDistance(pair.elements, then) < thickness_) {
      near = proximity(pair.elements, then);
    }
    if (!touches && distance < thickness_ && !(near && near->distance < distance)) {
      near = proximity(pair.elements, now);
    }
    if (!near || (!touches && near->distance >= thickness_)) continue;
    pushes_.push_back({&pair, *near, touches});
    any_passed = any_passed || touches;
  }
  if (any_passed) dropBesidePassed(positions, expected_);
  for (const Push& push : pushes_) {
    // k (thickness - n . (x + w u) weights) along n weights^T, with the new velocities u.
    const Proximity& near = push.near;
    const double gap = near.normal.dot(push.pair->corners(positions) * near.weights);
    spread(push, stiffness(*push.pair) * (thickness_ - gap) * near.normal, forces);
    matrix.addTie({push.pair->particles, near.weights, near.normal, w * w * stiffness(*push.pair)});
  }
  return static_cast<std::uint32_t>(pushes_.size());
}

void SelfCollision::addBounds(Eigen::VectorXd& stiffness, Eigen::VectorXd& /*damping*/) const {
  // A pair's matrix k G G^T has rows whose sums are at most 2 k.
  stiffness.array() += 2.0 * kPushesAtOnce * std::max(stiffness_[0], stiffness_[1]);
}

}  // namespace mass_spring
