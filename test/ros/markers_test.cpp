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

namespace mass_spring {
namespace {

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

Model modelOf(const std::string& objects) {
  return buildModel(readScene(readYamlText("objects: {" + objects + "}", "test"), ""));
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

MarkerArray drawStart(const Model& model, double rate, std::vector<std::uint32_t> pins,
                      bool start_over = false) {
  Markers markers(model, "stage", rate);
  std::vector<char> pinned(model.particleCount(), 0);
  for (const std::uint32_t particle : pins) pinned[particle] = 1;
  return markers.draw(model.start.positions, pinned, ros::Time(3, 4), start_over);
}

TEST(Markers, ShowEachParticleSpringTriangleAndPin) {
  const Model model = modelOf(cloth(3) + ", " + kRope);
  const MarkerArray array = drawStart(model, 30.0, {0, 4, 5});

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
  EXPECT_EQ(find(array, "sheet/surface")->points.size(), 3u * 8u);
  EXPECT_EQ(find(array, "sheet/pins")->points.size(), 1u);
  EXPECT_EQ(find(array, "cable/pins")->points.size(), 2u);
  EXPECT_EQ(find(array, "cable/pins")->points[1].x, 1.0);
  EXPECT_EQ(find(array, "cable/particles")->type, Marker::SPHERE_LIST);
  EXPECT_EQ(find(array, "cable/springs")->type, Marker::LINE_LIST);
  EXPECT_EQ(find(array, "sheet/surface")->type, Marker::TRIANGLE_LIST);
  EXPECT_EQ(find(array, "sheet/pins")->type, Marker::SPHERE_LIST);
}

TEST(Markers, DeleteWhatIsNotThere) {
  const Model model = modelOf(kRope);
  const MarkerArray array = drawStart(model, 30.0, {});
  EXPECT_EQ(find(array, "cable/pins")->action, Marker::DELETE);
  EXPECT_TRUE(find(array, "cable/pins")->points.empty());
  EXPECT_EQ(find(array, "cable/surface"), nullptr);
}

TEST(Markers, StartOverOnceAndDrawTheSameAfterwards) {
  const Model model = modelOf(cloth(3));
  Markers markers(model, "stage", 30.0);
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

TEST(Markers, ColourSpringsByStrain) {
  const Model model = modelOf(kRope);
  Markers markers(model, "stage", 30.0);
  Vectors positions = model.start.positions;
  positions(0, 1) += 0.1;  // stretches the first spring, compresses the second
  const MarkerArray array =
      markers.draw(positions, std::vector<char>(5, 0), ros::Time(1, 0), false);
  const auto& colors = find(array, "cable/springs")->colors;
  EXPECT_GT(colors[0].r, 0.9f);
  EXPECT_LT(colors[0].b, 0.2f);
  EXPECT_GT(colors[2].b, 0.9f);
  EXPECT_LT(colors[2].r, 0.2f);
  EXPECT_EQ(colors[4].r, colors[4].b);  // at rest: grey
}

TEST(Markers, StayBelow60MegabytesPerSecond) {
  const Model model = modelOf(cloth(100));
  std::vector<std::uint32_t> all(model.particleCount());
  for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
  for (const double rate : {1.0, 10.0, 30.0, 100.0}) {
    for (const auto& pins : {std::vector<std::uint32_t>{0, 99}, all}) {
      const MarkerArray array = drawStart(model, rate, pins);
      EXPECT_LE(rate * ros::serialization::serializationLength(array), 60e6) << rate << " Hz";
    }
  }
  // At the usual rate the surface shows the strain, one colour per triangle; at a low one there is
  // room for everything.
  const MarkerArray usual = drawStart(model, 30.0, {0, 99});
  ASSERT_NE(find(usual, "sheet/surface"), nullptr);
  EXPECT_EQ(find(usual, "sheet/surface")->colors.size(), 2u * 99u * 99u);
  EXPECT_EQ(Markers(model, "stage", 1.0).detail(), Detail::kFull);
}

TEST(Markers, DrawPointsWithoutExtentOrSprings) {
  const Model model = modelOf(
      "dust: {type: particles, positions: [[1, 1, 1], [1, 1, 1]], masses: 1.0, springs: [[0, 1]], "
      "stiffness: 1.0}, grain: {type: particles, positions: [[0, 0, 0]], masses: 1.0, springs: [], "
      "stiffness: []}");
  const MarkerArray array = drawStart(model, 30.0, {});
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
  Markers markers(model, "stage", 30.0);
  for (int frame = 0; frame < 2; ++frame) {
    std::vector<Eigen::Isometry3d> poses;
    for (const Shape& shape : model.contact->shapes()) poses.push_back(shape.geometryPose());
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
    EXPECT_DOUBLE_EQ(find(array, "contact/table")->scale.y, 0.2);
    // What is drawn of a plane lies below it.
    const Marker* floor = find(array, "contact/floor");
    EXPECT_DOUBLE_EQ(floor->pose.position.z + 0.5 * floor->scale.z, 0.0);
  }
}

}  // namespace
}  // namespace mass_spring
