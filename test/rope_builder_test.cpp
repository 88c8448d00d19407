#include <gtest/gtest.h>

#include "shapes.h"

namespace mass_spring {
namespace {

TEST(RopeBuilder, CountsFollowTheSegments) {
  for (const int segments : {1, 2, 3, 40}) {
    Rope rope = someRope(segments);
    EXPECT_EQ(build(rope).springs.size(), static_cast<std::size_t>(segments));
    rope.bend_stiffness = 3.0;
    const Model model = build(rope);
    expectSound(model);
    EXPECT_EQ(model.particleCount(), segments + 1u);
    auto counts = countByKind(model);
    EXPECT_EQ(counts[SpringKind::kStructural], static_cast<std::size_t>(segments));
    EXPECT_EQ(counts[SpringKind::kBending], static_cast<std::size_t>(segments - 1));
    EXPECT_TRUE(model.triangles.empty());
    EXPECT_FALSE(model.objects[0].has_surface);
  }
}

TEST(RopeBuilder, EndsAreExact) {
  for (const int segments : {1, 3, 7, 49}) {
    const Rope rope = someRope(segments);
    const Model model = build(rope);
    EXPECT_EQ(model.start.positions.col(0), rope.start);
    EXPECT_EQ(model.start.positions.col(segments), rope.end);
  }
}

// Springs in series: n of stiffness k stretch like one of k / n, whatever n.
TEST(RopeBuilder, AxialRigidityGivesTheSameRopeAtAnyResolution) {
  for (const int segments : {1, 4, 25}) {
    Rope rope = someRope(segments);
    rope.stiffness.reset();
    rope.axial_rigidity = 250.0;
    const Model model = build(rope);
    double compliance = 0.0;
    for (const Spring& spring : model.springs) compliance += 1.0 / spring.stiffness;
    const double length = (rope.end - rope.start).norm();
    // Relative, as the sum of 25 equal terms loses some last places.
    EXPECT_NEAR(compliance * 250.0 / length, 1.0, 1e-14);
  }
}

TEST(RopeBuilder, LengthZeroIsARopeOfRestLengthZero) {
  Rope rope = someRope(3);
  rope.end = rope.start;
  for (const Spring& spring : build(rope).springs) {
    EXPECT_EQ(spring.rest_length, 0.0);
    EXPECT_EQ(spring.stiffness, 500.0);
  }
}

}  // namespace
}  // namespace mass_spring
