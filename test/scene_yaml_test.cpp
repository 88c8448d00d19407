#include <gtest/gtest.h>

#include "mass_spring_sim/scene_reader.h"
#include "scene_text.h"

namespace mass_spring {
namespace {

Scene parsed(const std::string& yaml, const std::string& directory = "") {
  return readScene(readYamlText(yaml, "scene"), directory);
}

TEST(SceneYaml, ReadsBackAsTheSameScene) {
  const Scene scene = parsed(kSceneText);
  const std::string yaml = toYaml(scene);
  const Scene again = parsed(yaml);
  EXPECT_EQ(toYaml(again), yaml);
  EXPECT_EQ(again.frame_id, scene.frame_id);
  EXPECT_EQ(again.rate, scene.rate);
  ASSERT_EQ(again.objects.size(), scene.objects.size());
  EXPECT_EQ(again.objects[1].color, scene.objects[1].color);
  EXPECT_EQ(std::get<Rope>(again.objects[1].shape).stiffness, 1e4);
  EXPECT_EQ(std::get<Cloth>(again.objects[3].shape).orientation, Eigen::Vector3d(0.1, 0.2, 0.3));
  ASSERT_EQ(again.pins.size(), 2u);
  EXPECT_EQ(again.pins[1].particles, scene.pins[1].particles);
  EXPECT_EQ(again.effects.gravity->acceleration, scene.effects.gravity->acceleration);
  ASSERT_EQ(again.timeline.size(), 4u);
  EXPECT_TRUE(std::get<PinCommand>(again.timeline[1].command).here);
}

TEST(SceneYaml, KeepsEveryBitOfEveryNumber) {
  // Numbers with 17 digits, and orientations that were given as angles.
  Tree tree = sceneWith("rate", "133.33333333333334");
  put(tree, "objects.net.masses", "[0.1, 0.30000000000000004, 1.0e-300]");
  put(tree, "timeline[2].pin.orientation", "[0.1, 1.5707963267948966, -3.0]");
  const Scene scene = readScene(tree, "");
  const Scene again = parsed(toYaml(scene));
  EXPECT_EQ(again.rate, scene.rate);
  EXPECT_EQ(std::get<Particles>(again.objects[2].shape).masses,
            std::get<Particles>(scene.objects[2].shape).masses);
  EXPECT_EQ(std::get<PinCommand>(again.timeline[2].command).target.orientation.coeffs(),
            std::get<PinCommand>(scene.timeline[2].command).target.orientation.coeffs());
}

TEST(SceneYaml, KeepsEveryBitOfAnOrientation) {
  // Angles whose quaternion is off unit length by as much as rounding makes it: it is written, and
  // must not be normalized to other bits when it is read.
  for (const char* angles : {"[-2.3595808198513875, 1.0650184854696612, -2.8749517232378992]",
                             "[2.0811967694088445, -0.48383762644169304, -1.3221355255898424]",
                             "[1.9292774577225531, 0.26446332355071345, -0.61284862881173563]",
                             "[1.0422726253216616, 2.7677236735943103, 2.9130065320347382]"}) {
    const Scene scene = readScene(sceneWith("timeline[2].pin.orientation", angles), "");
    const std::string yaml = toYaml(scene);
    EXPECT_EQ(toYaml(parsed(yaml)), yaml);
  }
}

TEST(SceneYaml, SpellsOutDefaults) {
  const std::string yaml =
      toYaml(parsed("objects: {dot: {type: particles, positions: [[0, 0, 0]], masses: 1}}"));
  for (const char* line :
       {"frame_id: world\n", "rate: 100.0\n", "start_paused: false\n", "  scheme: tr_bdf2\n",
        "  newton_tolerance: 1.0e-06\n", "  markers: 30.0\n", "  state: 100.0\n",
        "  max_force: 1000000.0\n", "  max_speed: 1000.0\n", "  max_extent: 1000000.0\n",
        "    velocities: [[0.0, 0.0, 0.0]]\n"}) {
    EXPECT_NE(yaml.find(line), std::string::npos) << line << yaml;
  }
  EXPECT_EQ(toYaml(parsed(yaml)), yaml);
}

// What is written is what was resolved: another rate would resolve to another number.
TEST(SceneYaml, WritesTheRateOfStatesThatFollowsTheRateOfTheScene) {
  const std::string yaml =
      toYaml(parsed("rate: 400\n"
                    "objects: {dot: {type: particles, positions: [[0, 0, 0]], masses: 1}}"));
  EXPECT_NE(yaml.find("  state: 400.0\n"), std::string::npos) << yaml;
  EXPECT_EQ(toYaml(parsed(yaml)), yaml);
}

TEST(SceneYaml, WritesEveryKindOfCommand) {
  const std::string yaml = toYaml(
      parsed("objects: {dot: {type: particles, positions: [[0, 0, 0], [1, 0, 0]], masses: 1}}\n"
             "timeline:\n"
             "  - {time: 0, force: {forces: [[0, 0, 1], [0, 0, 2]], duration: -1, id: 'a: b'}}\n"
             "  - {time: 1, pin: {action: add, name: a, point: [1, 2, 3], radius: 4}}\n"
             "  - {time: 2, pin: {action: move, name: a, target: [1, 2, 3]}}\n"
             "  - {time: 3, pin: {action: remove, name: a}}\n"
             "  - {time: 4, pin: {action: add, name: b, particles: [1], target: [0, 0, 1],"
             " orientation: [0, 0, 1], follow_frame: tool}}\n"
             "  - {time: 4, pin: {action: move, name: b, target: [0, 0, 2], follow_frame: tool}}\n"
             "  - {time: 5, shape: {name: ball, target: [1, 2, 3], duration: 0.5}}\n"
             "  - {time: 6, clear: forces}\n"
             "  - {time: 6, clear: pins}\n"
             "effects: {contact: {stiffness: 10,"
             " shapes: {ball: {type: sphere, center: [0, 0, 0], radius: 1,"
             " follow_frame: tool}}}}\n"));
  const Scene again = parsed(yaml);
  EXPECT_EQ(toYaml(again), yaml);
  EXPECT_EQ(std::get<ForceCommand>(again.timeline[0].command).id, "a: b");
  EXPECT_EQ(std::get<PinCommand>(again.timeline[1].command).radius, 4.0);
  EXPECT_FALSE(std::get<PinCommand>(again.timeline[4].command).here);
  EXPECT_EQ(std::get<PinCommand>(again.timeline[4].command).follow_frame, "tool");
  EXPECT_EQ(std::get<PinCommand>(again.timeline[5].command).follow_frame, "tool");
  EXPECT_EQ(std::get<ShapeCommand>(again.timeline[6].command).duration, 0.5);
  EXPECT_EQ(std::get<ClearCommand>(again.timeline[7].command).what, ClearCommand::What::kForces);
  EXPECT_EQ(std::get<ClearCommand>(again.timeline[8].command).what, ClearCommand::What::kPins);
  EXPECT_EQ(again.effects.contact->shapes[0].follow_frame, "tool");
}

TEST(SceneYaml, QuotesNamesThatMeanSomethingElse) {
  const std::string yaml =
      toYaml(parsed("frame_id: 'true'\n"
                    "objects: {'on': {type: particles, positions: [[0, 0, 0]], masses: 1}}\n"
                    "pins: {'null': {object: 'on', particles: [0], follow_frame: tool0}}"));
  const Scene again = parsed(yaml);
  EXPECT_EQ(again.frame_id, "true");
  EXPECT_EQ(again.objects[0].name, "on");
  EXPECT_EQ(again.pins[0].name, "null");
  EXPECT_EQ(again.pins[0].follow_frame, "tool0");
}

TEST(SceneYaml, KeepsTheMeshFile) {
  const TemporaryFolder folder;
  folder.write("a b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const Scene scene =
      parsed("objects: {skin: {type: mesh, file: a b.obj, scale: 0.5, mass: 1, stiffness: 10}}",
             folder.path());
  const Scene again = parsed(toYaml(scene), folder.path());
  const Mesh& mesh = std::get<Mesh>(again.objects[0].shape);
  EXPECT_EQ(mesh.file, "a b.obj");
  EXPECT_EQ(mesh.scale, 0.5);
  EXPECT_EQ(mesh.vertices.size(), 3u);
}

}  // namespace
}  // namespace mass_spring
