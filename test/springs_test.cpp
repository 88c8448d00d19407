#include "effects/springs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <tuple>

#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/simulation.h"
#include "probe.h"
#include "problems.h"
#include "shapes.h"
#include "solvers/step_matrix.h"

// The vectorized loops against the formulas, spring by spring.
namespace mass_spring {
namespace {

struct Case {
  std::string name;
  Model model;
};

Model modelOf(Scene scene) {
  scene.solver.scheme = Scheme::kImplicitEuler;
  return buildModel(scene);
}

template <typename Shape>
Model modelOf(const Shape& shape) {
  Scene scene;
  scene.objects.push_back({"thing", {1, 0, 0, 1}, shape});
  return modelOf(scene);
}

/// A chain whose springs all differ; some are undamped, some damp only, some have no rest length,
/// and one in ten is missing.
Particles unequalChain(int n) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Particles chain;
  chain.damping.emplace();
  chain.rest_lengths.emplace();
  for (int i = 0; i < n; ++i) {
    chain.positions.emplace_back(0.1 * i, 0.02 * unit(random), 0.02 * unit(random));
    chain.velocities.emplace_back(Eigen::Vector3d::Zero());
    chain.masses.push_back(0.01);
    if (i == 0 || i % 10 == 0) continue;
    chain.springs.push_back({static_cast<std::uint32_t>(i - 1), static_cast<std::uint32_t>(i)});
    chain.stiffness.push_back(i % 7 == 0 ? 0.0 : 100.0 * unit(random));
    chain.damping->push_back(i % 3 == 0 ? 0.0 : unit(random));
    chain.rest_lengths->push_back(i % 5 == 0 ? 0.0 : 0.2 * unit(random));
  }
  return chain;
}

/// From later particles to earlier ones, also over 13 at a time.
Particles backwardChain(int n) {
  Particles chain = unequalChain(n);
  for (auto& ends : chain.springs) std::swap(ends[0], ends[1]);
  for (std::uint32_t i = 0; i + 13 < static_cast<std::uint32_t>(n); ++i) {
    chain.springs.push_back({i + 13, i});
    chain.stiffness.push_back(20.0);
    chain.damping->push_back(0.1);
    chain.rest_lengths->push_back(1.2);
  }
  return chain;
}

/// A random net with springs twice, the second time from the other end, and ends that coincide.
Particles hardNet(int n) {
  Particles net = randomNet(n, 50.0, 1.1, 5);
  for (int copy = 0; copy < 3; ++copy) {
    for (std::size_t s = 0; s < 20; ++s) {
      auto ends = net.springs[s];
      if (copy == 1) std::swap(ends[0], ends[1]);
      net.springs.push_back(ends);
      net.stiffness.push_back(net.stiffness[s]);
      net.rest_lengths->push_back(copy == 2 ? 0.0 : (*net.rest_lengths)[s]);
    }
  }
  net.positions[net.springs[0][0]] = net.positions[net.springs[0][1]];
  net.velocities.resize(net.positions.size(), Eigen::Vector3d::Zero());
  net.damping.emplace(net.springs.size(), 0.0);
  for (std::size_t s = 0; s < net.springs.size(); s += 2) (*net.damping)[s] = 0.3;
  return net;
}

/// Runs of several objects and gathered springs beside one another.
Scene severalObjects() {
  Scene scene;
  scene.objects.push_back({"sheet", {1, 0, 0, 1}, someCloth(40, 17)});
  scene.objects.push_back({"rope", {1, 0, 0, 1}, someRope(30)});
  scene.objects.push_back({"net", {1, 0, 0, 1}, hardNet(40)});
  return scene;
}

/// Away from rest, with the coincident ends still coincident, and moving.
void stir(Model& model) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const Vectors start = model.start.positions;
  for (Eigen::Index i = 0; i < start.cols(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      model.start.positions(axis, i) += 0.02 * unit(random);
      model.start.velocities(axis, i) = unit(random);
    }
  }
  for (const Spring& s : model.springs) {
    if (start.col(s.i) == start.col(s.j)) {
      model.start.positions.col(s.i) = model.start.positions.col(s.j);
    }
  }
}

std::vector<Case> cases() {
  std::vector<Case> list;
  const auto add = [&](const std::string& name, Model model) {
    stir(model);
    list.push_back({name, std::move(model)});
  };
  Lattice lattice = someLattice(4, 5, 6);
  lattice.damping = 0.2;
  Rope bending_rope = someRope(300);
  bending_rope.bend_stiffness = 10.0;
  add("cloth", modelOf(someCloth(23, 19)));
  add("cloth of several runs", modelOf(someCloth(50, 30)));
  add("cloth narrower than a vector", modelOf(someCloth(3, 40)));
  add("lattice", modelOf(lattice));
  add("undamped lattice", modelOf(someLattice(3, 3, 9)));
  add("rope", modelOf(bending_rope));
  add("one spring", modelOf(someRope(1)));
  add("mesh", modelOf(tetrahedron()));
  add("unequal chain", modelOf(unequalChain(500)));
  add("backward chain", modelOf(backwardChain(700)));
  add("hard net", modelOf(hardNet(150)));
  add("several objects", modelOf(severalObjects()));
  return list;
}

const Springs& springsOf(const Model& model) {
  return dynamic_cast<const Springs&>(*model.effects.front());
}

/// The formulas of the course notes: eq. 1, 2 and 5.
struct Plain {
  Vectors forces;
  double elastic = 0.0, dissipation = 0.0;
  double largest_force = 0.0;  // N, what a particle's forces could add up to

  explicit Plain(const Model& model) : forces(Vectors::Zero(3, model.particleCount())) {
    Eigen::VectorXd sizes = Eigen::VectorXd::Zero(model.particleCount());
    for (const Spring& s : model.springs) {
      const Eigen::Vector3d d = model.start.positions.col(s.j) - model.start.positions.col(s.i);
      const Eigen::Vector3d w = model.start.velocities.col(s.j) - model.start.velocities.col(s.i);
      const double l = d.norm();
      const Eigen::Vector3d n = l > 0.0 ? Eigen::Vector3d(d / l) : Eigen::Vector3d::UnitZ();
      const Eigen::Vector3d f = s.stiffness * (l - s.rest_length) * n + s.damping * w.dot(n) * n;
      forces.col(s.i) += f;
      forces.col(s.j) -= f;
      elastic += 0.5 * s.stiffness * (l - s.rest_length) * (l - s.rest_length);
      dissipation += 0.5 * s.damping * w.dot(n) * w.dot(n);
      const double size = s.stiffness * (l + s.rest_length) + s.damping * w.norm();
      sizes[s.i] += size;
      sizes[s.j] += size;
    }
    largest_force = sizes.maxCoeff();
  }
};

// Sums of a few dozen products in another order: some units in the last place of their sizes.
constexpr double kRoundings = 4e-15;

TEST(Springs, ForcesAndEnergiesFollowTheFormulas) {
  for (const Case& c : cases()) {
    const Plain plain(c.model);
    ASSERT_GT(plain.forces.norm(), 1.0) << c.name;
    const Springs& springs = springsOf(c.model);
    const State& at = c.model.start;
    // What is there already stays.
    const Vectors before = Vectors::Constant(3, c.model.particleCount(), 0.5);
    Vectors forces = before;
    Probe(springs).addForces(at.positions, at.velocities, forces);
    EXPECT_LT((forces - before - plain.forces).cwiseAbs().maxCoeff(),
              kRoundings * plain.largest_force)
        << c.name;

    Vectors again = before;
    Energy energy;
    energy.elastic = 3.0;
    double dissipation = 2.0;
    Probe(springs).addForces(at.positions, at.velocities, again, energy, dissipation);
    EXPECT_TRUE(again == forces) << c.name;
    // Energies are sums over all springs; their errors add up like a random walk at the worst.
    EXPECT_NEAR(energy.elastic - 3.0, plain.elastic, 1e-13 * (plain.elastic + 3.0)) << c.name;
    EXPECT_NEAR(dissipation - 2.0, plain.dissipation, 1e-13 * (plain.dissipation + 2.0)) << c.name;

    Energy alone;
    Probe(springs).addEnergy(at.positions, alone);
    EXPECT_NEAR(alone.elastic, plain.elastic, 1e-13 * plain.elastic) << c.name;

    // Held where they are, the directions of damping are what they are.
    Vectors held = before;
    Probe(springs).addForcesHolding(at.positions, at.positions, at.velocities, held, energy,
                                    dissipation);
    EXPECT_LT((held - forces).cwiseAbs().maxCoeff(), kRoundings * plain.largest_force) << c.name;
    EXPECT_NEAR(dissipation - 2.0, 2.0 * plain.dissipation, 1e-13 * (plain.dissipation + 2.0))
        << c.name;
  }
}

/// Spring by spring, with the rule of Projection.
std::uint32_t addPlainly(const Model& model, const MatrixWeights& weights, Projection projection,
                         StepMatrix& matrix) {
  const auto ratio = [&](const Spring& s) {
    const double l = (model.start.positions.col(s.j) - model.start.positions.col(s.i)).norm();
    return s.rest_length == 0.0 ? 1.0 : 1.0 - s.rest_length / l;
  };
  Eigen::VectorXd taken = Eigen::VectorXd::Zero(model.particleCount());
  for (const Spring& s : model.springs) {
    if (ratio(s) >= 0.0 || s.stiffness == 0.0) continue;
    taken[s.i] -= 2.0 * weights.stiffness * s.stiffness * ratio(s);
    taken[s.j] -= 2.0 * weights.stiffness * s.stiffness * ratio(s);
  }
  std::uint32_t projected = 0;
  for (const Spring& s : model.springs) {
    if (s.stiffness == 0.0 && s.damping == 0.0) continue;
    const Eigen::Vector3d d = model.start.positions.col(s.j) - model.start.positions.col(s.i);
    const Eigen::Vector3d n =
        d.norm() > 0.0 ? Eigen::Vector3d(d.normalized()) : Eigen::Vector3d::UnitZ();
    const bool light = projection == Projection::kWhereNeeded &&
                       (taken[s.i] >= matrix.mass(s.i) || taken[s.j] >= matrix.mass(s.j));
    const bool project = ratio(s) < 0.0 && (light || d.norm() == 0.0);
    if (project && s.stiffness > 0.0) ++projected;
    SymmetricBlock block = springStiffness(d, weights.stiffness * s.stiffness, s.rest_length,
                                           project || s.stiffness == 0.0);
    block += SymmetricBlock::axial(n, weights.damping * s.damping, 0.0);
    const std::size_t slot = matrix.pattern().slot(s.i, s.j);
    matrix.addElement(s.i, s.j, slot, block);
  }
  return projected;
}

double difference(const std::vector<SymmetricBlock>& a, const std::vector<SymmetricBlock>& b) {
  double largest = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    largest = std::max(largest, (a[k].dense() - b[k].dense()).cwiseAbs().maxCoeff());
  }
  return largest;
}

TEST(Springs, MatrixFollowsTheFormulas) {
  // Masses that keep all, some and none of the particles definite by themselves.
  bool some_projected = false, some_kept = false;
  for (const Case& c : cases()) {
    for (const Projection projection : {Projection::kNone, Projection::kWhereNeeded}) {
      for (const double h : {1e-4, 4e-3, 0.1}) {
        for (const MatrixWeights& weights :
             {MatrixWeights{1.0, h, h * h}, MatrixWeights{1.0, 0.0, h * h}}) {
          StepMatrix expected(c.model.pattern), matrix(c.model.pattern);
          expected.setMasses(1.0, c.model.masses);
          matrix.setMasses(1.0, c.model.masses);
          const std::uint32_t count = addPlainly(c.model, weights, projection, expected);
          EXPECT_EQ(Probe(springsOf(c.model))
                        .addDerivatives(c.model.start.positions, c.model.start.velocities, weights,
                                        projection, matrix),
                    count)
              << c.name;
          double size = 0.0;
          for (const SymmetricBlock& b : expected.diagonal())
            size = std::max(size, b.dense().norm());
          EXPECT_LT(difference(matrix.diagonal(), expected.diagonal()), kRoundings * size)
              << c.name;
          EXPECT_LT(difference(matrix.upper(), expected.upper()), kRoundings * size) << c.name;
          some_projected = some_projected || count > 100;
          some_kept = some_kept || (projection == Projection::kWhereNeeded && count == 0);
        }
      }
    }
  }
  EXPECT_TRUE(some_projected);
  EXPECT_TRUE(some_kept);
}

TEST(Springs, WithoutRestLengthAreLinear) {
  Particles pair;
  pair.positions = {{0.1, 0.2, 0.3}, {0.1, 0.2, 0.3}};
  pair.velocities = {{0, 0, 0}, {0, 0, 0}};
  pair.masses = {1.0, 1.0};
  pair.springs = {{0, 1}};
  pair.stiffness = {80.0};
  pair.rest_lengths = {{0.0}};
  const Model model = modelOf(pair);
  Vectors x = model.start.positions;
  for (const double distance : {0.0, 1e-200, 1e-20, 1e-3, 1e6}) {
    x.col(1) = x.col(0);
    x.col(0).setZero();
    x.col(1) = distance * Eigen::Vector3d(2.0, -1.0, 2.0);
    Vectors forces = Vectors::Zero(3, 2);
    Probe(springsOf(model)).addForces(x, model.start.velocities, forces);
    // Of lengths below 1e-154 the square underflows: they count as none.
    const Vectors expected = distance < 1e-150 ? Vectors(0.0 * x) : Vectors(80.0 * x);
    EXPECT_LT((forces.col(0) - expected.col(1)).norm(), 4e-16 * expected.norm() + 1e-300);
    EXPECT_EQ(forces.col(1), -forces.col(0));
  }
}

TEST(Springs, RepeatBitForBit) {
  for (const Case& c : cases()) {
    const State& at = c.model.start;
    const Springs other(c.model.springs, c.model.particleCount());
    Vectors first = Vectors::Zero(3, c.model.particleCount()), second = first;
    Energy energy, other_energy;
    double dissipation = 0.0, other_dissipation = 0.0;
    Probe probe(springsOf(c.model));
    probe.addForces(at.positions, at.velocities, first, energy, dissipation);
    probe.addForces(0.5 * at.positions, at.velocities, second);  // leaves no trace
    second.setZero();
    Probe(other).addForces(at.positions, at.velocities, second, other_energy, other_dissipation);
    EXPECT_TRUE(first == second) << c.name;
    EXPECT_EQ(energy.elastic, other_energy.elastic) << c.name;
    EXPECT_EQ(dissipation, other_dissipation) << c.name;
    second.setZero();
    probe.addForces(at.positions, at.velocities, second);
    EXPECT_TRUE(first == second) << c.name;
  }
}

// What is computed in the gaps of runs reaches nobody.
TEST(Springs, TakeWhatIsNotFiniteToNeighborsOnly) {
  Model model = modelOf(someCloth(23, 19));
  stir(model);
  const std::uint32_t bad = 5 * 23 + 22;  // at the end of a row
  model.start.positions(1, bad) = std::numeric_limits<double>::quiet_NaN();
  std::vector<char> spoiled(model.particleCount(), 0);
  for (const Spring& s : model.springs) {
    if (s.i == bad || s.j == bad) spoiled[s.i] = spoiled[s.j] = 1;
  }
  Vectors forces = Vectors::Zero(3, model.particleCount());
  Probe(springsOf(model)).addForces(model.start.positions, model.start.velocities, forces);
  for (std::uint32_t i = 0; i < model.particleCount(); ++i) {
    EXPECT_EQ(forces.col(i).allFinite(), !spoiled[i]) << i;
  }
}

using SpringKey = std::tuple<std::uint32_t, std::uint32_t, double, double, double>;

TEST(SpringBatches, HoldEverySpringOnce) {
  for (const Case& c : cases()) {
    std::vector<SpringKey> expected, found;
    for (const Spring& s : c.model.springs) {
      if (s.stiffness == 0.0 && s.damping == 0.0) continue;
      expected.emplace_back(s.i, s.j, s.stiffness, s.damping, s.rest_length);
    }
    std::vector<char> lane_taken(springsOf(c.model).batches().lanes(), 0);
    const auto find = [&](std::uint32_t i, std::uint32_t j, std::size_t lane, double stiffness,
                          double damping, double length) {
      found.emplace_back(i, j, stiffness, damping, length);
      EXPECT_FALSE(lane_taken.at(lane)) << c.name;
      lane_taken[lane] = 1;
    };
    springsOf(c.model).batches().forEach({}, find);
    std::sort(expected.begin(), expected.end());
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected) << c.name;
  }
}

// Nothing of ropes, cloth and lattices is gathered, and equal springs share their values.
TEST(SpringBatches, FindTheRunsOfGrids) {
  Rope rope = someRope(1000);
  rope.bend_stiffness = 10.0;
  const auto expectRuns = [](const Model& model) {
    const SpringBatches& batches = springsOf(model).batches();
    EXPECT_TRUE(batches.gathered().empty());
    for (const SpringBatch& batch : batches.runs()) EXPECT_TRUE(batch.uniform);
    // Gaps and the ends of families: less than a fifth more lanes than springs.
    EXPECT_LT(batches.lanes(), 1.2 * static_cast<double>(model.springs.size()));
  };
  expectRuns(modelOf(rope));
  expectRuns(modelOf(someCloth(50, 50)));
  expectRuns(modelOf(someCloth(8, 200)));
  expectRuns(modelOf(someLattice(20, 20, 20)));
}

TEST(SpringBatches, LeaveAbsentDampingOut) {
  Cloth cloth = someCloth(9, 9);
  cloth.damping.reset();
  const Model undamped = modelOf(cloth);
  EXPECT_FALSE(springsOf(undamped).batches().damped());
  EXPECT_EQ(springsOf(undamped).traits().names, std::vector<std::string>{"springs"});
  EXPECT_FALSE(springsOf(undamped).traits().damping_depends_on_position);
  cloth.damping = 0.1;
  EXPECT_EQ(springsOf(modelOf(cloth)).traits().names,
            (std::vector<std::string>{"springs", "spring_damping"}));
}

}  // namespace
}  // namespace mass_spring
