#include "problems.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <random>

#include "mass_spring_sim/model.h"

namespace mass_spring {

Scene netScene(Particles particles, Scheme scheme, double rate) {
  Scene scene;
  scene.rate = rate;
  scene.solver.scheme = scheme;
  particles.velocities.resize(particles.positions.size(), Eigen::Vector3d::Zero());
  Object object;
  object.name = "net";
  object.shape = std::move(particles);
  scene.objects.push_back(std::move(object));
  return scene;
}

Scene hangingCloth(int n, Scheme scheme) {
  Cloth sheet;
  sheet.size = Eigen::Vector2d(1.0, 1.0);
  sheet.resolution = {n, n};
  sheet.mass = 0.2;
  sheet.stiffness = 1000.0;
  sheet.shear_stiffness = 500.0;
  sheet.bend_stiffness = 100.0;
  sheet.damping = 0.1;
  Scene scene;
  scene.rate = 60.0;
  scene.solver.scheme = scheme;
  scene.objects.push_back({"sheet", Eigen::Vector4d(1, 1, 1, 1), sheet});
  scene.effects.gravity = GravityOptions{Eigen::Vector3d(0, 0, -9.81)};
  pin(scene, {0, static_cast<std::uint32_t>(n - 1)});
  return scene;
}

Scene sheetsAndRopes(int n, int segments, Scheme scheme) {
  Cloth cloth;
  cloth.size = {0.4, 0.4};
  cloth.resolution = {n, n};
  cloth.mass = 0.1;
  cloth.stiffness = 10.0;
  Rope rope;
  rope.start = Eigen::Vector3d::Zero();
  rope.end = {0.4, 0.0, 0.0};
  rope.segments = segments;
  rope.mass = 0.1;
  rope.stiffness = 10.0;
  Scene scene;
  scene.solver.scheme = scheme;
  scene.objects = {{"a", {}, cloth}, {"b", {}, cloth}, {"c", {}, rope}, {"d", {}, rope}};
  return scene;
}

double observedOrder(const std::function<Vectors(double rate)>& end, double rate) {
  const Vectors coarse = end(rate), middle = end(2.0 * rate), fine = end(4.0 * rate);
  const double difference = (middle - fine).norm();
  EXPECT_GT(difference, 1e-10);  // what solvers leave has to be far below
  return std::log2((coarse - middle).norm() / difference);
}

bool sameBytes(const Vectors& a, const Vectors& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

void pin(Scene& scene, std::vector<std::uint32_t> particles) {
  scene.pins.push_back({"hold", scene.objects[0].name, std::move(particles)});
}

std::vector<Scheme> allSchemes() {
  std::vector<Scheme> all;
  for (const SchemeInfo& scheme : schemes()) {
    if (scheme.name != "auto") all.push_back(scheme.scheme);
  }
  return all;
}

bool solvesSprings(Scheme scheme) { return info(scheme).implicit && scheme != Scheme::kXpbd; }

namespace {

template <typename Condition>
std::vector<Scheme> schemesThat(Condition condition) {
  std::vector<Scheme> all = allSchemes(), some;
  std::copy_if(all.begin(), all.end(), std::back_inserter(some), condition);
  return some;
}

}  // namespace

std::vector<Scheme> summingSchemes() {
  return schemesThat([](Scheme scheme) { return scheme != Scheme::kXpbd; });
}

std::vector<Scheme> solvingSchemes() { return schemesThat(solvesSprings); }

std::string schemeName(const testing::TestParamInfo<Scheme>& scheme) {
  return info(scheme.param).name;
}

double Oscillator::angularFrequency() const { return std::sqrt(stiffness / mass); }

double Oscillator::dampingRatio() const { return damping / (2.0 * std::sqrt(stiffness * mass)); }

double Oscillator::displacement(double time) const {
  const double decay = dampingRatio() * angularFrequency();
  const double w = angularFrequency() * std::sqrt(1.0 - dampingRatio() * dampingRatio());
  return amplitude * std::exp(-decay * time) *
         (std::cos(w * time) + decay / w * std::sin(w * time));
}

Scene Oscillator::scene(Scheme scheme, double rate) const {
  Particles net;
  net.positions = {Eigen::Vector3d::Zero(), Eigen::Vector3d(rest_length + amplitude, 0, 0)};
  net.masses = {1.0, mass};
  net.springs = {{0, 1}};
  net.stiffness = {stiffness};
  if (damping > 0.0) net.damping = {{damping}};
  net.rest_lengths = {{rest_length}};
  Scene scene = netScene(std::move(net), scheme, rate);
  pin(scene, {0});
  return scene;
}

Particles randomNet(int n, double stiffness, double slack, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Particles net;
  for (int i = 0; i < n; ++i) {
    const double x = unit(random), y = unit(random), z = unit(random);
    net.positions.emplace_back(x, y, z);
    net.masses.push_back(0.01 + 0.02 * unit(random));
  }
  const auto join = [&](int i, int j) {
    if (i == j) return;
    net.springs.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j)});
    net.stiffness.push_back(stiffness * (0.5 + unit(random)));
  };
  for (int i = 1; i < n; ++i) join(i, static_cast<int>(unit(random) * i));
  for (int k = 0; k < n; ++k)
    join(static_cast<int>(unit(random) * n), static_cast<int>(unit(random) * n));
  net.rest_lengths.emplace();
  for (const auto& s : net.springs) {
    net.rest_lengths->push_back(slack * (net.positions[s[0]] - net.positions[s[1]]).norm());
  }
  return net;
}

Particles byHand(const Scene& scene) {
  Model model;
  appendObject(scene.objects.at(0), model);
  Particles net;
  net.damping.emplace();
  net.rest_lengths.emplace();
  for (Eigen::Index i = 0; i < model.masses.size(); ++i) {
    net.positions.push_back(model.start.positions.col(i));
    net.velocities.push_back(model.start.velocities.col(i));
    net.masses.push_back(model.masses[i]);
  }
  for (const Spring& s : model.springs) {
    net.springs.push_back({s.i, s.j});
    net.stiffness.push_back(s.stiffness);
    net.damping->push_back(s.damping);
    net.rest_lengths->push_back(s.rest_length);
  }
  return net;
}

Scene freeParticles(Scheme scheme) {
  Particles net;
  net.positions = {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(2, 0, 0)};
  net.masses = {0.5, 0.5, 0.5};
  return netScene(net, scheme, 100.0);
}

Particles chain(int links, double length, const Eigen::Vector3d& direction, double mass,
                double stiffness) {
  Particles net;
  for (int i = 0; i <= links; ++i) {
    net.positions.push_back(i * length * direction.normalized());
    net.masses.push_back(mass);
    if (i > 0)
      net.springs.push_back({static_cast<std::uint32_t>(i - 1), static_cast<std::uint32_t>(i)});
  }
  net.velocities.assign(net.positions.size(), Eigen::Vector3d::Zero());
  net.stiffness.assign(net.springs.size(), stiffness);
  net.rest_lengths.emplace(net.springs.size(), length);
  return net;
}

}  // namespace mass_spring
