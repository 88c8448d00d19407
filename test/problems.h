#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "mass_spring_sim/scene.h"
#include "mass_spring_sim/state.h"

namespace mass_spring {

/// Problems whose answers are known, shared by the tests.

constexpr double kGravity = 9.81;  // m/s^2

/// A vacuum scene of one object "net" with the given solver; no pins, no gravity.
Scene netScene(Particles particles, Scheme scheme, double rate);

/// All schemes that step by themselves, for parameterised tests; `auto` chooses one of them.
std::vector<Scheme> allSchemes();
/// All but xpbd, which takes one spring after the other: closed forms of chains are not its own.
std::vector<Scheme> summingSchemes();
/// Those that solve for all springs at once, so that what rests is in equilibrium.
std::vector<Scheme> solvingSchemes();
bool solvesSprings(Scheme scheme);
std::string schemeName(const testing::TestParamInfo<Scheme>& scheme);

/// One mass on a spring along x, its other end (particle 0, at the origin) pinned.
struct Oscillator {
  double mass = 0.3;         // kg
  double stiffness = 40.0;   // N/m
  double damping = 0.0;      // N s/m
  double rest_length = 1.0;  // m
  double amplitude = 0.25;   // m, displacement of particle 1 at the start, at rest

  double angularFrequency() const;  // rad/s
  double dampingRatio() const;
  double displacement(double time) const;  // the exact solution, m; underdamped
  Scene scene(Scheme scheme, double rate) const;
};

/// A seeded random net of n particles in a box of 1 m: a random spanning tree and as many springs
/// again, masses 0.01 to 0.03 kg, rest lengths `slack` times the distances at the start.
Particles randomNet(int n, double stiffness, double slack, unsigned seed);

/// An n x n cloth of 1 m, level at the start, held at two adjacent corners, in steps of 1/60 s.
Scene hangingCloth(int n, Scheme scheme);

/// Two sheets of n x n particles and two ropes, each 0.4 m long and of 0.1 kg, all in one place: to
/// be thrown into each other.
Scene sheetsAndRopes(int n, int segments, Scheme scheme);

/// The particles and springs of a scene's first object, by hand: to be moved before the start.
Particles byHand(const Scene& scene);

/// Three particles of 0.5 kg, 1 m apart, without springs, in a vacuum, in steps of 0.01 s: forces
/// act on them and nothing else.
Scene freeParticles(Scheme scheme = Scheme::kImplicitEuler);

/// A chain of `links` springs of rest length `length` from the origin along a direction, at rest.
Particles chain(int links, double length, const Eigen::Vector3d& direction, double mass,
                double stiffness);

/// The order at which answers converge as the rate doubles, twice, from the one given [Hz].
/// @param end  the positions at the end of a run with some rate
double observedOrder(const std::function<Vectors(double rate)>& end, double rate);

bool sameBytes(const Vectors& a, const Vectors& b);

/// The first pin of a scene: the given particles of its first object.
void pin(Scene& scene, std::vector<std::uint32_t> particles);

}  // namespace mass_spring
