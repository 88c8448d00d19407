#include "ros/markers.h"

#include <gtest/gtest.h>
#include <ros/serialization.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "effects/contact.h"
#include "mass_spring_sim/scene_reader.h"
#include "ros/shape_markers.h"
#include "ros/surfaces.h"

namespace mass_spring {
namespace {

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

/// @param more  further keys of the scene
Scene sceneOf(const std::string& objects, const std::string& more = "") {
  return readScene(readYamlText("frame_id: stage\nobjects: {" + objects + "}\n" + more, "test"),
                   "");
}

std::string cloth(int n) {
  const std::string size = std::to_string(n);
  return "sheet: {type: cloth, size: [1, 1], resolution: [" + size + ", " + size +
         "], mass: 0.2, stiffness: 1000, shear_stiffness: 500, bend_stiffness: 100}";
}

const char kRope[] =
    "cable: {type: rope, start: [0, 0, 1], end: [1, 0, 1], segments: 4, "
    "mass: 0.1, stiffness: 10, color: [0, 1, 0, 1]}";

const Marker* find(const MarkerArray& array, const std::string& ns) {
  const auto marker = std::find_if(array.markers.begin(), array.markers.end(),
                                   [&](const Marker& m) { return m.ns == ns; });
  return marker == array.markers.end() ? nullptr : &*marker;
}

MarkerArray drawStart(const Scene& scene, double rate, std::vector<std::uint32_t> pins,
                      bool start_over = false) {
  const Model model = buildModel(scene);
  Markers markers(scene, model, rate);
  std::vector<char> pinned(model.particleCount(), 0);
  for (const std::uint32_t particle : pins) pinned[particle] = 1;
  return markers.draw(model.start.positions, pinned, ros::Time(3, 4), start_over);
}

TEST(Markers, ShowEachParticleSpringTriangleAndPin) {
  const MarkerArray array = drawStart(sceneOf(cloth(3) + ", " + kRope), 30.0, {0, 4, 5});

  std::set<std::pair<std::string, int>> names;
  for (const Marker& marker : array.markers) {
    names.emplace(marker.ns, marker.id);
    EXPECT_EQ(marker.header.frame_id, "stage");
    EXPECT_EQ(marker.header.stamp, ros::Time(3, 4));
    EXPECT_EQ(marker.action, Marker::ADD);
    EXPECT_GT(marker.scale.x, 0.0);
    EXPECT_EQ(marker.pose.orientation.w, 1.0);
    EXPECT_GT(marker.color.a, 0.0f);
  }
  EXPECT_EQ(names, (std::set<std::pair<std::string, int>>{{"cable/particles", 0},
                                                          {"cable/springs", 0},
                                                          {"cable/surface", 0},
                                                          {"cable/pins", 0},
                                                          {"sheet/particles", 0},
                                                          {"sheet/springs", 0},
                                                          {"sheet/surface", 0},
                                                          {"sheet/pins", 0}}));
  EXPECT_EQ(names.size(), array.markers.size());

  // A 3 x 3 cloth: 12 structural, 8 shear and 6 bending springs, 8 triangles.
  EXPECT_EQ(find(array, "sheet/particles")->points.size(), 9u);
  EXPECT_EQ(find(array, "sheet/springs")->points.size(), 2u * 26u);
  EXPECT_EQ(find(array, "sheet/springs")->colors.size(), 2u * 26u);
  // Each triangle has a front and a back; a tube has two triangles on each side of each spring.
  EXPECT_EQ(find(array, "sheet/surface")->points.size(), 2u * 3u * 8u);
  EXPECT_EQ(find(array, "sheet/surface")->colors.size(), 2u * 3u * 8u);
  EXPECT_EQ(find(array, "cable/surface")->points.size(), 4u * 2u * kTubeSides * 3u);
  EXPECT_EQ(find(array, "cable/surface")->colors.size(), 4u * 2u * kTubeSides * 3u);
  EXPECT_EQ(find(array, "sheet/pins")->points.size(), 1u);
  EXPECT_EQ(find(array, "cable/pins")->points.size(), 2u);
  EXPECT_EQ(find(array, "cable/pins")->points[1].x, 1.0);
  EXPECT_EQ(find(array, "cable/particles")->type, Marker::SPHERE_LIST);
  EXPECT_EQ(find(array, "cable/springs")->type, Marker::LINE_LIST);
  EXPECT_EQ(find(array, "sheet/surface")->type, Marker::TRIANGLE_LIST);
  EXPECT_EQ(find(array, "sheet/pins")->type, Marker::SPHERE_LIST);
}

TEST(Markers, DeleteWhatIsNotThere) {
  const MarkerArray array =
      drawStart(sceneOf("net: {type: particles, positions: [[0, 0, 0], [1, 0, 0]], masses: 1.0, "
                        "springs: [[0, 1]], stiffness: 1.0}"),
                30.0, {});
  EXPECT_EQ(find(array, "net/pins")->action, Marker::DELETE);
  EXPECT_TRUE(find(array, "net/pins")->points.empty());
  EXPECT_EQ(find(array, "net/surface"), nullptr);
}

TEST(Markers, StartOverOnceAndDrawTheSameAfterwards) {
  const Scene scene = sceneOf(cloth(3));
  const Model model = buildModel(scene);
  Markers markers(scene, model, 30.0);
  const std::vector<char> pinned(9, 0);
  const auto draw = [&](bool start_over) {
    return markers.draw(model.start.positions, pinned, ros::Time(1, 0), start_over);
  };
  const MarkerArray before = draw(false);
  MarkerArray fresh = draw(true);
  ASSERT_EQ(fresh.markers.front().action, Marker::DELETEALL);
  fresh.markers.erase(fresh.markers.begin());
  const MarkerArray after = draw(false);
  ASSERT_EQ(before.markers.size(), fresh.markers.size());
  ASSERT_EQ(before.markers.size(), after.markers.size());
  for (std::size_t i = 0; i < before.markers.size(); ++i) {
    for (const MarkerArray* other : {&std::as_const(fresh), &after}) {
      EXPECT_EQ(before.markers[i].ns, other->markers[i].ns);
      EXPECT_EQ(before.markers[i].type, other->markers[i].type);
      EXPECT_EQ(before.markers[i].action, other->markers[i].action);
      EXPECT_EQ(before.markers[i].points.size(), other->markers[i].points.size());
      EXPECT_EQ(before.markers[i].colors.size(), other->markers[i].colors.size());
    }
  }
}

TEST(Markers, ColorSpringsByStrain) {
  const Scene scene = sceneOf(kRope);
  const Model model = buildModel(scene);
  Markers markers(scene, model, 30.0);
  Vectors positions = model.start.positions;
  positions(0, 1) += 0.1;  // stretches the first spring, compresses the second
  const MarkerArray array =
      markers.draw(positions, std::vector<char>(5, 0), ros::Time(1, 0), false);
  const auto& colors = find(array, "cable/springs")->colors;
  EXPECT_GT(colors[0].r, 0.9f);
  EXPECT_LT(colors[0].b, 0.2f);
  EXPECT_GT(colors[2].b, 0.9f);
  EXPECT_LT(colors[2].r, 0.2f);
  EXPECT_EQ(colors[4].r, colors[4].b);  // at rest: gray
}

TEST(Markers, StayBelow60MegabytesPerSecond) {
  const std::string rope =
      "cable: {type: rope, start: [0, 0, 1], end: [9, 0, 1], segments: 2500, mass: 1, stiffness: "
      "1}";
  for (const std::string& objects : {cloth(100), rope}) {
    const Scene scene = sceneOf(objects);
    std::vector<std::uint32_t> all(buildModel(scene).particleCount());
    for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
    for (const double rate : {1.0, 10.0, 30.0, 100.0}) {
      for (const auto& pins : {std::vector<std::uint32_t>{0, 99}, all}) {
        const MarkerArray array = drawStart(scene, rate, pins);
        EXPECT_LE(rate * ros::serialization::serializationLength(array), 60e6) << rate << " Hz";
      }
    }
  }
  // At the usual rate there is one color per triangle of the cloth, and no tube of so long a rope;
  // at a low one there is room for everything.
  const MarkerArray usual = drawStart(sceneOf(cloth(100)), 30.0, {0, 99});
  ASSERT_NE(find(usual, "sheet/surface"), nullptr);
  EXPECT_EQ(find(usual, "sheet/surface")->colors.size(), 2u * 99u * 99u);
  EXPECT_EQ(find(usual, "sheet/particles"), nullptr);
  EXPECT_EQ(find(drawStart(sceneOf(rope), 30.0, {}), "cable/surface"), nullptr);
  EXPECT_NE(find(drawStart(sceneOf(rope), 10.0, {}), "cable/surface"), nullptr);
  EXPECT_EQ(find(drawStart(sceneOf(cloth(100)), 1.0, {}), "sheet/surface")->colors.size(),
            2u * 3u * 2u * 99u * 99u);
}

double brightness(const std_msgs::ColorRGBA& color) { return color.r + color.g + color.b; }

TEST(Markers, PaintFrontAndBackOfASurfaceInDifferentColors) {
  const MarkerArray array = drawStart(sceneOf(cloth(2)), 30.0, {});
  const Marker& surface = *find(array, "sheet/surface");
  ASSERT_EQ(surface.points.size(), 12u);
  // Level as it is, its front points up: towards the light, and above its back.
  for (const int front : {0, 6}) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_GT(surface.points[front + k].z, 0.0);
      EXPECT_LT(surface.points[front + 3 + k].z, 0.0);
      // The default color is blue, and a back is paler.
      const auto& above = surface.colors[front + k];
      const auto& below = surface.colors[front + 3 + k];
      EXPECT_GT(above.b, 2.0F * above.r);
      EXPECT_LT(below.b, 2.0F * below.r);
    }
  }
}

TEST(Markers, DrawBothSidesOfASurfaceAtOneDepthIfItCanBeSeenThrough) {
  const MarkerArray array = drawStart(
      sceneOf(cloth(2).substr(0, cloth(2).size() - 1) + ", color: [1, 0, 0, 0.5]}"), 30.0, {});
  EXPECT_EQ(find(array, "sheet/surface")->points.size(), 6u);
}

TEST(Markers, DrawOnlyTheOutsideOfAClosedSurface) {
  const MarkerArray array = drawStart(sceneOf("skin: {type: mesh, file: " MASS_SPRING_SOURCE_DIR
                                              "/config/meshes/bunny.obj, mass: 1, stiffness: 100}"),
                                      1.0, {});
  EXPECT_EQ(find(array, "skin/surface")->points.size(), 3u * 3674u);  // as the file says
}

std::string lattice(const std::string& more) {
  return "block: {type: lattice, size: [1, 1, 1], resolution: [3, 4, 5], mass: 1, stiffness: 100" +
         more + "}";
}

TEST(Markers, DrawTheOuterFacesOfALattice) {
  const Scene scene = sceneOf(lattice(""));
  const Model model = buildModel(scene);
  const MarkerArray array = drawStart(scene, 30.0, {});
  const Marker& surface = *find(array, "block/surface");
  // Cells of two faces across each axis: 3 x 4, 4 x 2 and 2 x 3. It is closed and hence has no
  // back.
  ASSERT_EQ(surface.points.size(), 2u * (12u + 8u + 6u) * 2u * 3u);
  for (std::size_t i = 0; i < surface.points.size(); i += 3) {
    const auto at = [&](std::size_t k) {
      const auto& p = surface.points[i + k];
      return Eigen::Vector3d(p.x, p.y, p.z);
    };
    // Of a box around the origin, each outward normal points away from it.
    EXPECT_GT((at(1) - at(0)).cross(at(2) - at(0)).dot(at(0) + at(1) + at(2)), 0.0);
  }
}

TEST(Markers, LeaveOutTheTornFacesOfALattice) {
  const Scene scene = sceneOf(lattice(""));
  const Model model = buildModel(scene);
  Markers markers(scene, model, 30.0);
  std::vector<char> gone(model.springs.size(), 0);
  // The first spring joins particles 0 and 1, along an edge of the block: a cell on either side of
  // it.
  ASSERT_EQ(std::make_pair(model.springs[0].i, model.springs[0].j), std::make_pair(0u, 1u));
  gone[0] = 1;
  const Model torn = withoutSprings(model, gone);
  markers.follow(torn);
  const MarkerArray array =
      markers.draw(model.start.positions, std::vector<char>(60, 0), ros::Time(), false);
  EXPECT_EQ(find(array, "block/surface")->points.size(), (2u * (12u + 8u + 6u) - 2u) * 2u * 3u);
}

TEST(Markers, ShadeFoldsAtEachDetail) {
  const Scene scene = sceneOf(cloth(30));
  const Model model = buildModel(scene);
  Vectors positions = model.start.positions;
  // A wave along x, whose slopes lean to the light and away from it.
  for (Eigen::Index i = 0; i < positions.cols(); ++i) {
    positions(2, i) = 0.1 * std::sin(12.0 * positions(0, i));
  }
  for (const double rate : {10.0, 200.0}) {
    Markers markers(scene, model, rate);
    ASSERT_EQ(markers.detail(), rate == 10.0 ? Detail::kFull : Detail::kSurface);
    const MarkerArray array =
        markers.draw(positions, std::vector<char>(900, 0), ros::Time(), false);
    std::vector<double> shades;
    for (const auto& color : find(array, "sheet/surface")->colors) {
      for (const float part : {color.r, color.g, color.b, color.a}) {
        EXPECT_GE(part, 0.0F);
        EXPECT_LE(part, 1.0F);
      }
      shades.push_back(brightness(color));
    }
    // Without shades, the quotient would be 1; eyes see a difference of a few percent.
    const auto [dark, bright] = std::minmax_element(shades.begin(), shades.end());
    EXPECT_GT(*bright, 1.3 * *dark) << rate << " Hz";
  }
}

TEST(Markers, DrawRopesAsTubesOfTheirDiameter) {
  const auto farthest = [](const Marker& tube) {
    double radius = 0.0;
    for (const auto& point : tube.points) {
      radius = std::max(radius, std::hypot(point.y, point.z - 1.0));
    }
    return radius;
  };
  // The rope lies along x, at z = 1 m. It keeps 2 cm off shapes: so thick is half of it.
  const MarkerArray thick = drawStart(
      sceneOf(kRope,
              "effects: {contact: {stiffness: 100, thickness: 0.02, shapes: {ball: {type: sphere, "
              "center: [0, 0, 0], radius: 0.1}}}}"),
      30.0, {0});
  // To rounding: the corners are sums of numbers about 1 m.
  EXPECT_NEAR(farthest(*find(thick, "cable/surface")), 0.02, 1e-15);
  // A pin is larger than the rope.
  EXPECT_GT(find(thick, "cable/pins")->scale.x, 0.04);
  // Without any contact, it can be seen.
  EXPECT_GT(farthest(*find(drawStart(sceneOf(kRope), 30.0, {}), "cable/surface")), 0.003);
}

TEST(Markers, DrawTubesOfRopesThatAreFoldedOrHaveNoLength) {
  const Scene scene = sceneOf(kRope);
  const Model model = buildModel(scene);
  Vectors positions = model.start.positions;
  positions.col(2) = positions.col(1);  // no length
  positions.col(4) = positions.col(2);  // back to where it came from
  Markers markers(scene, model, 30.0);
  const MarkerArray array = markers.draw(positions, std::vector<char>(5, 0), ros::Time(), false);
  const Marker& tube = *find(array, "cable/surface");
  EXPECT_EQ(tube.points.size(), 3u * 2u * kTubeSides * 3u);
  for (const auto& point : tube.points) {
    EXPECT_TRUE(std::isfinite(point.x + point.y + point.z));
  }
}

TEST(Markers, DrawPointsWithoutExtentOrSprings) {
  const Scene scene = sceneOf(
      "dust: {type: particles, positions: [[1, 1, 1], [1, 1, 1]], masses: 1.0, springs: [[0, 1]], "
      "stiffness: 1.0}, grain: {type: particles, positions: [[0, 0, 0]], masses: 1.0, springs: [], "
      "stiffness: []}");
  const MarkerArray array = drawStart(scene, 30.0, {});
  EXPECT_GT(find(array, "dust/particles")->scale.x, 0.0);
  EXPECT_GT(find(array, "dust/springs")->scale.x, 0.0);
  EXPECT_GT(find(array, "grain/particles")->scale.x, 0.0);
  EXPECT_EQ(find(array, "grain/springs"), nullptr);
}

TEST(Markers, ShowTheShapesOfContact) {
  const Scene scene = readScene(readYamlText(R"(
frame_id: stage
objects: {net: {type: particles, positions: [[0, 0, 1]], masses: 0.1}}
effects:
  contact:
    stiffness: 100
    shapes:
      bar: {type: capsule, start: [0, 0, 1], end: [2, 0, 1], radius: 0.1}
      floor: {type: plane, point: [0, 0, 0], normal: [0, 0, 1]}
      table: {type: box, center: [1, 2, 3], size: [0.1, 0.2, 0.3]}
)",
                                             "test"),
                                "");
  const Model model = buildModel(scene);
  Markers markers(scene, model, 30.0);
  for (int frame = 0; frame < 2; ++frame) {
    std::vector<Eigen::Isometry3d> poses;
    for (std::size_t s = 0; s < model.shapes.size(); ++s) {
      const RigidMotion& motion = model.start.effects.shapes[s];
      poses.push_back(PlacedShape(model.shapes[s], motion, 0.0).geometryPose());
    }
    const ros::Time stamp(frame, 5);
    const MarkerArray& array = markers.draw(model.start.positions, std::vector<char>(1, 0), stamp,
                                            false, shapeMarkers(scene, poses, stamp));
    const Marker* bar = find(array, "contact/bar");
    ASSERT_NE(bar, nullptr);
    EXPECT_EQ(bar->type, Marker::CYLINDER);
    EXPECT_EQ(bar->header.stamp, ros::Time(frame, 5));
    EXPECT_DOUBLE_EQ(bar->pose.position.x, 1.0);
    EXPECT_DOUBLE_EQ(bar->scale.z, 2.0);
    // Its z axis lies along x: a quarter turn about y.
    EXPECT_NEAR(bar->pose.orientation.y, std::sqrt(0.5), 1e-15);
    EXPECT_EQ(std::count_if(array.markers.begin(), array.markers.end(),
                            [](const Marker& m) { return m.ns == "contact/bar"; }),
              3);
    const Marker* table = find(array, "contact/table");
    EXPECT_EQ(table->type, Marker::TRIANGLE_LIST);
    EXPECT_EQ(table->points.size(), 6u * 2u * 3u);
    EXPECT_EQ(table->colors.size(), 6u * 2u);
    for (const auto& corner : table->points) {
      EXPECT_DOUBLE_EQ(std::abs(corner.x), 0.05);
      EXPECT_DOUBLE_EQ(std::abs(corner.y), 0.1);
      EXPECT_DOUBLE_EQ(std::abs(corner.z), 0.15);
    }
    // Faces across x, y and z, the far one first: light from above falls on the one across z.
    EXPECT_GT(brightness(table->colors[8]), brightness(table->colors[10]));
    const Marker* floor = find(array, "contact/floor");
    EXPECT_EQ(floor->points.size(), 2u * 3u);
    for (const auto& corner : floor->points) EXPECT_EQ(corner.z, 0.0);
    // Shapes stand out from it.
    EXPECT_GT(brightness(floor->colors[0]), 1.05 * brightness(table->colors[8]));
  }
}

}  // namespace
}  // namespace mass_spring
