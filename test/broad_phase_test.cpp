#include "effects/broad_phase.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "problems.h"

// Against all pairs, one by one: none that is near may be missing.
namespace mass_spring {
namespace {

constexpr double kNear = 0.05;  // m
constexpr double kNearMargin = 0.25 * kNear;

Model heapOfThings() { return buildModel(sheetsAndRopes(6, 8, Scheme::kSymplecticEuler)); }

Vectors scattered(std::mt19937& random, Eigen::Index count, double size) {
  std::uniform_real_distribution<double> number(-size, size);
  return Vectors::NullaryExpr(3, count, [&] { return number(random); });
}

using Particles4 = std::array<std::uint32_t, 4>;

/// Of all elements, but those that share a particle or belong together.
std::vector<ElementPair> pairsOneByOne(const CollisionElements& elements) {
  std::vector<ElementPair> all;
  const auto add = [&](const Particles4& p, Elements kind, bool apart) {
    const ElementPair pair{p, kind, 0.0};
    const bool beside = elements.object[p[0]] == elements.object[p[2]] &&
                        proximity(kind, pair.corners(elements.rest)).distance < kNear;
    if (apart && !beside) all.push_back(pair);
  };
  for (std::uint32_t i = 0; i < elements.object.size(); ++i) {
    for (const auto& [a, b, c] : elements.triangles) {
      add({i, a, b, c}, Elements::kParticleAndTriangle, i != a && i != b && i != c);
    }
  }
  for (std::size_t s = 0; s < elements.segments; ++s) {
    for (std::size_t e = s + 1; e < elements.edges.size(); ++e) {
      const auto& [a, b] = elements.edges[s];
      const auto& [c, d] = elements.edges[e];
      add({a, b, c, d}, Elements::kSegments, a != c && a != d && b != c && b != d);
    }
  }
  return all;
}

TEST(BroadPhase, MissesNothingThatIsNear) {
  const Model model = heapOfThings();
  const CollisionElements elements(model);
  const std::vector<ElementPair> all = pairsOneByOne(elements);
  const Eigen::Index n = model.start.positions.cols();
  ThreadPool alone(1);
  BroadPhase broad(elements, kNear, alone);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  int near = 0, far = 0;
  for (int trial = 0; trial < 10; ++trial) {
    const Vectors from = scattered(random, n, 0.4);
    const Vectors way = scattered(random, n, 0.1).colwise() + Eigen::Vector3d(1.0, 2.0, 3.0);
    broad.refresh(from, from + way);
    std::map<Particles4, double> apart;
    for (const ElementPair& pair : broad.pairs()) apart[pair.particles] = pair.apart;
    EXPECT_EQ(apart.size(), broad.pairs().size());  // each once
    // Anywhere on the way, off it by less than the margin.
    const Vectors off = scattered(random, n, 0.3 * kNearMargin);
    const Vectors x = (from + share(random) * way + off).colwise() + Eigen::Vector3d(4.0, 5.0, 6.0);
    const double strayed = broad.strayed(x);
    ASSERT_TRUE(broad.covers(strayed));
    for (const ElementPair& pair : all) {
      const double distance = proximity(pair.elements, pair.corners(x)).distance;
      const auto found = apart.find(pair.particles);
      near += distance < kNear;
      EXPECT_TRUE(found != apart.end() || !(distance < kNear));
      if (found == apart.end()) continue;
      far += found->second > kNear;
      // Rounding of numbers of size 10.
      EXPECT_GE(distance, found->second - 2.0 * strayed - 1e-13);
    }
    EXPECT_FALSE(broad.covers(broad.strayed(x + scattered(random, n, 4.0 * kNearMargin))));
  }
  EXPECT_GT(near, 1000);
  EXPECT_GT(far, 1000);
}

TEST(BroadPhase, ThreadsFindTheSameInTheSameOrder) {
  const Model model = heapOfThings();
  const CollisionElements elements(model);
  ThreadPool nobody(1), helpers(3);
  BroadPhase alone(elements, kNear, nobody), shared(elements, kNear, helpers);
  std::mt19937 random(4);
  for (int trial = 0; trial < 10; ++trial) {
    const Vectors from = scattered(random, model.start.positions.cols(), 0.3);
    const Vectors to = from + scattered(random, from.cols(), 0.1);
    alone.refresh(from, to);
    shared.refresh(from, to);
    ASSERT_EQ(alone.pairs().size(), shared.pairs().size());
    ASSERT_GT(alone.pairs().size(), 100u);
    for (std::size_t p = 0; p < alone.pairs().size(); ++p) {
      EXPECT_EQ(alone.pairs()[p].particles, shared.pairs()[p].particles);
    }
  }
}

}  // namespace
}  // namespace mass_spring
