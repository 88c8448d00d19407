#pragma once

#include <array>
#include <vector>

#include "effects/box_tree.h"
#include "effects/proximity.h"
#include "mass_spring_sim/model.h"
#include "thread_pool.h"

namespace mass_spring {

/// What may touch: all particles and the triangles of cloth and mesh; and segments, which are the
/// structural springs of all other objects and the particles that belong to nothing else, with one
/// another and with the edges of triangles.
struct CollisionElements {
  explicit CollisionElements(const Model& model);

  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::array<std::uint32_t, 2>> edges;  ///< segments first, then those of triangles
  std::size_t segments = 0;
  std::vector<std::uint32_t> object;  ///< per particle
  Vectors rest;                       ///< m, the particles at the start
};

struct ElementPair {
  std::array<std::uint32_t, 4> particles;
  Elements elements;
  double apart;  ///< m, no more than their distance anywhere on their ways

  Corners corners(const Vectors& positions) const {
    Corners x;
    for (int a = 0; a < 4; ++a) x.col(a) = positions.col(particles[static_cast<std::size_t>(a)]);
    return x;
  }
};

/// All pairs of elements that may be near each other: those near enough where it last looked, with
/// a margin. They serve until particles have left that margin about a common motion, all of them
/// along their own straight ways and together any way. Pairs that share a particle, and those of
/// one object that are near already at the start, are no pairs: nothing holds a sheet off itself
/// next to a fold. The order of pairs does not depend on when it looked, and so sums over them do
/// not.
class BroadPhase {
 public:
  /// @param elements  that outlive this
  /// @param distance  m, > 0: nearer pairs are found
  /// @param threads   to look for them with
  BroadPhase(const CollisionElements& elements, double distance, ThreadPool& threads);

  const std::vector<ElementPair>& pairs() const { return pairs_; }
  /// m, how far the particles have left their ways at most: two elements are no nearer than they
  /// were to be, less twice that, also on a straight way between any such positions.
  double strayed(const Vectors& positions) const;
  /// Whether pairs() has all that are near if they have strayed as far.
  bool covers(double strayed) const { return strayed <= margin_; }
  /// Finds the pairs for positions on the way from one place to another.
  void refresh(const Vectors& from, const Vectors& to);

 private:
  // More than there are threads, as elements have near ones in some places only.
  static constexpr std::uint32_t kParts = 8;
  /// What one thread finds, in the order of the elements that it looks round.
  struct Found {
    std::vector<std::uint32_t> boxes;
    std::vector<ElementPair> pairs;
  };
  template <std::size_t N>
  AlignedBox box(const std::array<std::uint32_t, N>& particles) const;
  void findRoundParticle(std::uint32_t particle, Found& found) const;
  void findRoundSegment(std::uint32_t segment, Found& found) const;
  void take(std::array<std::uint32_t, 4> particles, Elements elements, Found& found) const;
  /// find(e, found) for each of so many elements.
  template <typename Find>
  void findPairs(std::size_t elements, const Find& find);

  const CollisionElements& elements_;
  double distance_, margin_;
  ThreadPool& threads_;
  std::vector<ElementPair> pairs_;
  Vectors from_, to_, way_;  // none before the first refresh
  Eigen::Vector3d mean_way_;
  BoxTree triangles_, edges_;
  std::vector<AlignedBox> boxes_;
  std::array<Found, kParts> found_;
};

}  // namespace mass_spring
