#include "effects/springs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "effects/spring_direction.h"
#include "solvers/step_matrix.h"

namespace mass_spring {
namespace {

constexpr double kNoFloor = -std::numeric_limits<double>::infinity();

/// The ends' coordinates of gathered springs.
struct GatheredEnds {
  alignas(64) double of[3][SpringBatch::kMaxLanes];

  EndColumns gather(const std::vector<std::uint32_t>& ends, std::uint32_t lanes,
                    const Vectors& vectors) {
    const std::size_t springs = ends.size();
    for (std::size_t s = 0; s < springs; ++s) {
      const double* from = vectors.data() + 3 * std::size_t{ends[s]};
      for (int axis = 0; axis < 3; ++axis) of[axis][s] = from[axis];
    }
    for (auto& values : of) std::fill(values + springs, values + lanes, 0.0);
    return {of[0], of[1], of[2]};
  }
};

EndColumns columnsFrom(const Columns& columns, std::uint32_t particle) {
  return {columns[0] + particle, columns[1] + particle, columns[2] + particle};
}

}  // namespace

SymmetricBlock springStiffness(const Eigen::Vector3d& d, double stiffness, double rest_length,
                               bool project) {
  const SpringDirection direction(d);
  // The share of k that acts across the spring; linear without rest length, also at length 0.
  double r = rest_length == 0.0 ? 1.0 : 1.0 - rest_length / direction.length;
  if (project) r = std::max(r, 0.0);
  return SymmetricBlock::axial(direction.n, stiffness, stiffness * r);
}

struct Springs::Room : Scratch {
  Columns positions, velocities;
  Columns forces, diagonal;  // zero between calls
  Eigen::VectorXd taken;     // and then the floors
};

Springs::Springs(const std::vector<Spring>& springs, std::uint32_t particles, bool yielding)
    : Effect(Traits()), batches_(springs, yielding), particles_(particles) {
  if (batches_.elastic()) traits_.names.push_back("springs");
  if (batches_.damped()) traits_.names.push_back("spring_damping");
  traits_.damping_depends_on_position = batches_.damped();
}

std::unique_ptr<Scratch> Springs::makeScratch(ThreadPool& /*threads*/) const {
  auto room = std::make_unique<Room>();
  if (!batches_.runs().empty()) {
    room->positions.reset(particles_, 3);
    room->forces.reset(particles_, 3);
    if (batches_.damped()) room->velocities.reset(particles_, 3);
  }
  if (!slots_.empty()) {
    room->taken.setZero(Eigen::Index{particles_} + Columns::kBeyond);
    room->diagonal.reset(particles_, 6);
  }
  return room;
}

template <typename Visit, typename Finish>
void Springs::forEachBatch(const Point& point, bool damped, Room& room, Visit visit,
                           Finish finish) const {
  const Vectors &positions = point.positions, &velocities = point.velocities;
  SpringBatches::RestLengths rest_lengths;
  SpringLanes lanes;
  const auto describe = [&](const SpringBatch& batch) {
    lanes.lanes = batch.lanes;
    lanes.uniform = batch.uniform;
    lanes.damped = batch.damped && damped;
    lanes.stiffness = batches_.stiffness(batch);
    lanes.rest_length = batches_.restLength(batch, point.effects.rest_lengths, rest_lengths);
    lanes.damping = lanes.damped ? batches_.damping(batch) : nullptr;
  };
  // Coordinates come into the first cache and results leave it as the runs go by.
  const auto particles = static_cast<std::uint32_t>(positions.cols());
  std::uint32_t separated = 0, finished = 0;
  for (const SpringBatch& batch : batches_.runs()) {
    const std::uint32_t needed = std::min(batch.needed, particles);
    if (needed > separated) {
      separate(positions, separated, needed, room.positions);
      if (damped && batches_.damped()) {
        separate(velocities, separated, needed, room.velocities);
      }
      separated = needed;
    }
    describe(batch);
    lanes.xi = columnsFrom(room.positions, batch.i);
    lanes.xj = columnsFrom(room.positions, batch.j);
    if (lanes.damped) {
      lanes.vi = columnsFrom(room.velocities, batch.i);
      lanes.vj = columnsFrom(room.velocities, batch.j);
    }
    visit(batch, lanes);
    const std::uint32_t done = std::min(batch.finished, particles);
    if (done > finished) finish(finished, done);
    finished = std::max(finished, done);
  }
  GatheredEnds ends[4];
  for (const SpringBatch& batch : batches_.gathered()) {
    describe(batch);
    lanes.xi = ends[0].gather(batch.ends_i, batch.lanes, positions);
    lanes.xj = ends[1].gather(batch.ends_j, batch.lanes, positions);
    if (lanes.damped) {
      lanes.vi = ends[2].gather(batch.ends_i, batch.lanes, velocities);
      lanes.vj = ends[3].gather(batch.ends_j, batch.lanes, velocities);
    }
    visit(batch, lanes);
  }
}

void Springs::addTo(Vectors& forces, const SpringBatch& batch, LaneResults<3>& force, Room& room) {
  if (batch.ends_i.empty()) {
    force.clear(batch);
    addLanes(force, batch, room.forces);
    return;
  }
  for (std::size_t s = 0; s < batch.ends_i.size(); ++s) {
    const Eigen::Vector3d f(force.of(0)[s], force.of(1)[s], force.of(2)[s]);
    forces.col(batch.ends_i[s]) += f;
    forces.col(batch.ends_j[s]) -= f;
  }
}

void Springs::addForces(const Point& point, bool damped, Room& room, Vectors& forces) const {
  LaneResults<3> force;
  forEachBatch(
      point, damped, room,
      [&](const SpringBatch& batch, const SpringLanes& lanes) {
        springForces(lanes, force);
        addTo(forces, batch, force, room);
      },
      [&](std::uint32_t from, std::uint32_t to) { moveInto(forces, from, to, room.forces); });
}

void Springs::addForcesAndEnergies(const Point& point, bool damped, Room& room, Vectors* forces,
                                   double& elastic, double& dissipation) const {
  LaneResults<3> force;
  LaneResults<2> energies;
  forEachBatch(
      point, damped, room,
      [&](const SpringBatch& batch, const SpringLanes& lanes) {
        springForcesAndEnergies(lanes, force, energies);
        if (forces) addTo(*forces, batch, force, room);
        energies.clear(batch);
        elastic += sumLanes(energies.of(0), batch.lanes);
        dissipation += sumLanes(energies.of(1), batch.lanes);
      },
      [&](std::uint32_t from, std::uint32_t to) {
        if (forces) moveInto(*forces, from, to, room.forces);
      });
}

void Springs::addDamping(const Vectors& held, const Vectors& velocities, Vectors& forces,
                         double& dissipation) const {
  batches_.forEach({}, [&](std::uint32_t i, std::uint32_t j, std::size_t /*lane*/,
                           double /*stiffness*/, double damping, double /*rest_length*/) {
    if (damping == 0.0) return;
    const Eigen::Vector3d n = SpringDirection(held.col(j) - held.col(i)).n;
    const double rate = n.dot(velocities.col(j) - velocities.col(i));
    const Eigen::Vector3d f = damping * rate * n;
    forces.col(i) += f;
    forces.col(j) -= f;
    dissipation += 0.5 * damping * rate * rate;
  });
}

void Springs::add(const Point& point, Scratch* scratch, const Sums& sums) const {
  Room& room = *static_cast<Room*>(scratch);
  const bool damped = sums.forces && !sums.damping_positions;
  if (damped && !sums.energy && !sums.dissipation) {
    addForces(point, true, room, *sums.forces);
    return;
  }
  double unwanted = 0.0;
  double& elastic = sums.energy ? sums.energy->elastic : unwanted;
  double& dissipation = sums.dissipation ? *sums.dissipation : unwanted;
  addForcesAndEnergies(point, damped, room, sums.forces, elastic, dissipation);
  if (sums.forces && sums.damping_positions) {
    addDamping(*sums.damping_positions, point.velocities, *sums.forces, dissipation);
  }
}

std::uint32_t Springs::linearize(const Point& point, Scratch* scratch, double w, StepMatrix& matrix,
                                 Vectors& forces) const {
  // Damping is linear in v: f(x, v) + D v = f(x, 0).
  addForces(point, false, *static_cast<Room*>(scratch), forces);
  return addDerivatives(point, scratch, {1.0, w, w * w}, Projection::kWhereNeeded, matrix);
}

// With d = x_j - x_i = l n and w = v_j - v_i, f_i = k (l - L) n + k_d (w . n) n changes by
//   df_i = k (along n + r across) + k_d [(dw . n + w . dn) n + (w . n) dn],
//   dd = along n + across,  r = 1 - L/l,  dn = across / l.
// Where the ends coincide n is a constant that stands in for a direction, dn = 0, and r is that of
// the projected stiffness.
void Springs::addForceDerivative(const Point& point, Scratch* /*scratch*/, const Vectors& dx,
                                 const Vectors& dv, Vectors& df) const {
  const Vectors &x = point.positions, &v = point.velocities;
  const auto add = [&](std::uint32_t i, std::uint32_t j, std::size_t /*lane*/, double stiffness,
                       double damping, double rest_length) {
    const Eigen::Vector3d d = x.col(j) - x.col(i);
    const double length = d.norm();
    const bool coincident = length == 0.0;
    const double inverse = coincident ? 0.0 : 1.0 / length;
    const Eigen::Vector3d n = coincident ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d(d * inverse);
    const Eigen::Vector3d dd = dx.col(j) - dx.col(i);
    const double along = n.dot(dd);
    const Eigen::Vector3d across = dd - along * n;
    const double r = coincident && rest_length > 0.0 ? 0.0 : 1.0 - rest_length * inverse;
    Eigen::Vector3d f = stiffness * (along * n + r * across);
    if (damping > 0.0) {
      const Eigen::Vector3d dn = inverse * across;
      const Eigen::Vector3d w = v.col(j) - v.col(i);
      const Eigen::Vector3d dw = dv.col(j) - dv.col(i);
      f += damping * ((dw.dot(n) + w.dot(dn)) * n + w.dot(n) * dn);
    }
    df.col(i) += f;
    df.col(j) -= f;
  };
  batches_.forEach(point.effects.rest_lengths, add);
}

void Springs::addPattern(PatternBuilder& pattern) const {
  batches_.forEach({}, [&](std::uint32_t i, std::uint32_t j, auto...) { pattern.couple(i, j); });
}

void Springs::findSlots(const BlockPattern& pattern) {
  slots_.assign(batches_.lanes(), 0);
  batches_.forEach({}, [&](std::uint32_t i, std::uint32_t j, std::size_t lane, auto...) {
    slots_[lane] = static_cast<std::uint32_t>(pattern.slot(i, j));
  });
}

void Springs::findFloors(const Point& point, const MatrixWeights& weights, Projection projection,
                         const StepMatrix& matrix, Room& room) const {
  if (projection == Projection::kNone) {
    room.taken.setConstant(kNoFloor);
    return;
  }
  LaneResults<1> taken;
  room.taken.setZero();
  forEachBatch(
      point, false, room,
      [&](const SpringBatch& batch, const SpringLanes& lanes) {
        springIndefiniteness(lanes, weights.stiffness, taken);
        if (batch.ends_i.empty()) {
          taken.clear(batch);
          addLanes(taken, batch, room.taken.data());
          return;
        }
        for (std::size_t s = 0; s < batch.ends_i.size(); ++s) {
          room.taken[batch.ends_i[s]] += taken.of(0)[s];
          room.taken[batch.ends_j[s]] += taken.of(0)[s];
        }
      },
      [](auto...) {});
  const std::uint32_t particles = matrix.pattern().size();
  for (std::uint32_t i = 0; i < particles; ++i) {
    room.taken[i] = room.taken[i] < matrix.mass(i) ? kNoFloor : 0.0;
  }
}

// Where its mass outweighs what compressed springs take from a particle's diagonal block, the
// matrix stays definite without projection; a spring is projected if that fails at one of its ends.
std::uint32_t Springs::addDerivatives(const Point& point, Scratch* scratch,
                                      const MatrixWeights& weights, Projection projection,
                                      StepMatrix& matrix) const {
  Room& room = *static_cast<Room*>(scratch);
  findFloors(point, weights, projection, matrix, room);
  LaneResults<6> block;
  LaneResults<1> projected;
  double count = 0.0;
  SymmetricBlock* upper = matrix.upper().data();
  forEachBatch(
      point, false, room,
      [&](const SpringBatch& batch, SpringLanes lanes) {
        lanes.damped = batch.damped && weights.damping > 0.0;
        if (lanes.damped) lanes.damping = batches_.damping(batch);
        const std::uint32_t* slots = slots_.data() + batch.first_lane;
        if (batch.ends_i.empty()) {
          springBlocks(lanes, room.taken.data() + batch.i, room.taken.data() + batch.j, weights,
                       block, projected);
          block.clear(batch);
          projected.clear(batch);
          addLanes(block, batch, room.diagonal);
          subtractBlocks(block, slots, batch.lanes, upper);
        } else {
          alignas(64) double floor_i[SpringBatch::kMaxLanes], floor_j[SpringBatch::kMaxLanes];
          const std::size_t springs = batch.ends_i.size();
          for (std::size_t s = 0; s < springs; ++s) {
            floor_i[s] = room.taken[batch.ends_i[s]];
            floor_j[s] = room.taken[batch.ends_j[s]];
          }
          std::fill(floor_i + springs, floor_i + batch.lanes, 0.0);
          std::fill(floor_j + springs, floor_j + batch.lanes, 0.0);
          springBlocks(lanes, floor_i, floor_j, weights, block, projected);
          for (std::size_t s = 0; s < batch.ends_i.size(); ++s) {
            matrix.addElement(batch.ends_i[s], batch.ends_j[s], slots[s],
                              {block.of(0)[s], block.of(1)[s], block.of(2)[s], block.of(3)[s],
                               block.of(4)[s], block.of(5)[s]});
          }
        }
        count += sumLanes(projected.of(0), batch.lanes);
      },
      [&](std::uint32_t from, std::uint32_t to) {
        moveInto(matrix.diagonal(), from, to, room.diagonal);
      });
  return static_cast<std::uint32_t>(count);
}

}  // namespace mass_spring
