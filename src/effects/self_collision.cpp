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
double defaultStiffness(const Model& model, Elements elements, double thickness) {
  const bool surface = elements == Elements::kParticleAndTriangle;
  std::vector<double> stiffnesses,
      masses(model.masses.data(), model.masses.data() + model.masses.size());
  for (const Spring& s : model.springs) {
    if (s.kind != SpringKind::kStructural || s.stiffness == 0.0) continue;
    if (model.objectOf(s.i).has_surface != surface) continue;
    stiffnesses.push_back(s.stiffness * std::max(1.0, s.rest_length / thickness));
  }
  const double all = std::max(median(std::move(stiffnesses)),
                              kFirm * model.rate * model.rate * median(std::move(masses)));
  return surface ? all / kTrianglesRound : all;
}

}  // namespace

/// A pair of elements that push each other.
struct SelfCollision::Push {
  const ElementPair* pair;
  Proximity near;
  bool passed;  ///< through each other
  /// Along the normal, with the weights.
  double side() const { return passed ? -1.0 : 1.0; }
  /// vectors += the push of a force [N], or what is like one, on the first element
  void spread(const Eigen::Vector3d& force, Vectors& vectors) const {
    for (int a = 0; a < 4; ++a) {
      vectors.col(pair->particles[static_cast<std::size_t>(a)]) += near.weights[a] * force;
    }
  }
};

/// The pairs that are near, and the sub-step that is under way.
class SelfCollision::Room : public Scratch {
 public:
  Room(const CollisionElements& elements, double thickness, ThreadPool& threads)
      : thickness_(thickness),
        broad_(elements, thickness, threads),
        beside_(elements.object.size(), 0) {}

  const std::vector<ElementPair>& pairs() const { return broad_.pairs(); }
  void begin(const Vectors& positions, const Vectors& velocities, double h);
  void end() { under_way_ = false; }
  /// Pairs for these positions and the way there from where the sub-step began. @return m, those
  /// that are to be further apart push nothing at these positions, and have not passed on this way
  double cover(const Vectors& positions);
  double depth(const Push& push) const { return thickness_ - push.side() * push.near.distance; }
  /// m, the distance where it is below the thickness, else no more than that.
  double distanceWithin(const ElementPair& pair, const Corners& x) const;
  /// All pairs that push each other, until the next call.
  const std::vector<Push>& findPushes(const Vectors& positions);
  /// The same about where a linearized step of w [s] is expected to end, or about the first touch
  /// on the way there.
  const std::vector<Push>& expectPushes(const Vectors& positions, const Vectors& velocities,
                                        double w);

 private:
  /// Drops misled pairs: elements that lie beside a pair that has passed through each other see it
  /// on the wrong side, although they have not been passed themselves.
  void dropBesidePassed(const Vectors& from, const Vectors& to);
  /// Finds the pairs for the way there.
  void refresh(const Vectors& positions);
  /// m, at most that of the pair where the sub-step that is under way began.
  double startDistance(std::size_t pair);

  double thickness_;
  BroadPhase broad_;
  std::vector<Push> pushes_;
  std::vector<char> beside_;             // per particle, whether something has passed it
  std::vector<double> start_distances_;  // m, of the pairs, while a sub-step is under way
  double start_strayed_ = 0.0;           // m, as far as particles had when it began
  bool under_way_ = false;
  Vectors start_, expected_;
};

SelfCollision::SelfCollision(const SelfCollisionOptions& options, const Model& model)
    : Effect(Traits{{"self_collision"}}), elements_(model), thickness_(options.thickness) {
  traits_.ties = true;
  traits_.length = thickness_;
  for (const Elements e : {Elements::kParticleAndTriangle, Elements::kSegments}) {
    stiffness_[static_cast<std::size_t>(e)] =
        options.stiffness ? *options.stiffness : defaultStiffness(model, e, options.thickness);
  }
}

std::unique_ptr<Scratch> SelfCollision::makeScratch(ThreadPool& threads) const {
  return std::make_unique<Room>(elements_, thickness_, threads);
}

SelfCollision::Room& SelfCollision::roomOf(Scratch* scratch) {
  return *static_cast<Room*>(scratch);
}

void SelfCollision::beginSubstep(Scratch& scratch, const Vectors& positions,
                                 const Vectors& velocities, double h) const {
  roomOf(&scratch).begin(positions, velocities, h);
}

bool SelfCollision::endSubstep(Scratch& scratch, const Vectors& positions) const {
  Room& room = roomOf(&scratch);
  bool passed = false;
  if (positions.allFinite()) {
    for (const Push& push : room.findPushes(positions)) passed = passed || push.passed;
  }
  room.end();
  return passed;
}

void SelfCollision::Room::begin(const Vectors& positions, const Vectors& velocities, double h) {
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

double SelfCollision::Room::distanceWithin(const ElementPair& pair, const Corners& x) const {
  const double least = leastDistance(pair.elements, x);
  return least < thickness_ ? proximity(pair.elements, x).distance : least;
}

void SelfCollision::Room::refresh(const Vectors& positions) {
  broad_.refresh(under_way_ ? start_ : positions, positions);
  start_strayed_ = 0.0;
  start_distances_.assign(broad_.pairs().size(), kUnknown);
}

double SelfCollision::Room::startDistance(std::size_t pair) {
  double& distance = start_distances_[pair];
  if (distance == kUnknown) {
    const ElementPair& p = broad_.pairs()[pair];
    distance = distanceWithin(p, p.corners(start_));
  }
  return distance;
}

double SelfCollision::Room::cover(const Vectors& positions) {
  double strayed = broad_.strayed(positions);
  if (!broad_.covers(strayed)) {
    refresh(positions);
    strayed = broad_.strayed(positions);
  }
  return thickness_ + 2.0 * (under_way_ ? std::max(strayed, start_strayed_) : strayed);
}

const std::vector<SelfCollision::Push>& SelfCollision::Room::findPushes(const Vectors& positions) {
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
  return pushes_;
}

void SelfCollision::Room::dropBesidePassed(const Vectors& from, const Vectors& to) {
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

const std::vector<SelfCollision::Push>& SelfCollision::Room::expectPushes(const Vectors& positions,
                                                                          const Vectors& velocities,
                                                                          double w) {
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
  return pushes_;
}

void SelfCollision::add(const Point& point, Scratch* scratch, const Sums& sums) const {
  Room& room = roomOf(scratch);
  if (sums.forces == nullptr) {
    if (sums.energy == nullptr) return;
    const double reach = room.cover(point.positions);
    for (const ElementPair& pair : room.pairs()) {
      if (pair.apart >= reach) continue;
      const double depth = thickness_ - room.distanceWithin(pair, pair.corners(point.positions));
      if (depth > 0.0) sums.energy->elastic += 0.5 * stiffness(pair) * depth * depth;
    }
    return;
  }
  for (const Push& push : room.findPushes(point.positions)) {
    const double k = stiffness(*push.pair), depth = room.depth(push);
    if (sums.energy) sums.energy->elastic += 0.5 * k * depth * depth;
    push.spread(k * depth * push.side() * push.near.normal, *sums.forces);
  }
}

// With G = side normal weights^T: df = -k dg G + k depth dG, dg = G . dx.
void SelfCollision::addForceDerivative(const Point& point, Scratch* scratch, const Vectors& dx,
                                       const Vectors& /*dv*/, Vectors& df) const {
  const Room& room = roomOf(scratch);
  for (const Push& push : roomOf(scratch).findPushes(point.positions)) {
    const Proximity& near = push.near;
    const Corners changed = push.pair->corners(dx);
    const ProximityRate turned = rate(near, push.pair->corners(point.positions), changed);
    const double pressure = stiffness(*push.pair) * room.depth(push) * push.side();
    const double more = -stiffness(*push.pair) * near.normal.dot(changed * near.weights);
    push.spread(more * near.normal + pressure * turned.normal, df);
    for (int a = 0; a < 4; ++a) {
      df.col(push.pair->particles[static_cast<std::size_t>(a)]) +=
          pressure * turned.weights[a] * near.normal;
    }
  }
}

std::uint32_t SelfCollision::addDerivatives(const Point& point, Scratch* scratch,
                                            const MatrixWeights& weights, Projection projection,
                                            StepMatrix& matrix) const {
  if (weights.stiffness == 0.0) return 0;
  const std::vector<Push>& pushes = roomOf(scratch).findPushes(point.positions);
  for (const Push& push : pushes) {
    matrix.addTie({push.pair->particles, push.near.weights, push.near.normal,
                   weights.stiffness * stiffness(*push.pair)});
  }
  return projection == Projection::kNone ? 0 : static_cast<std::uint32_t>(pushes.size());
}

std::uint32_t SelfCollision::linearize(const Point& point, Scratch* scratch, double w,
                                       StepMatrix& matrix, Vectors& forces) const {
  const std::vector<Push>& pushes =
      roomOf(scratch).expectPushes(point.positions, point.velocities, w);
  for (const Push& push : pushes) {
    // k (thickness - n . (x + w u) weights) along n weights^T, with the new velocities u.
    const Proximity& near = push.near;
    const double gap = near.normal.dot(push.pair->corners(point.positions) * near.weights);
    push.spread(stiffness(*push.pair) * (thickness_ - gap) * near.normal, forces);
    matrix.addTie({push.pair->particles, near.weights, near.normal, w * w * stiffness(*push.pair)});
  }
  return static_cast<std::uint32_t>(pushes.size());
}

void SelfCollision::addBounds(Eigen::VectorXd& stiffness, Eigen::VectorXd& /*damping*/) const {
  // A pair's matrix k G G^T has rows whose sums are at most 2 k.
  stiffness.array() += 2.0 * kPushesAtOnce * std::max(stiffness_[0], stiffness_[1]);
}

}  // namespace mass_spring
