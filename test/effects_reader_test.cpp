#include <gtest/gtest.h>

#include "mass_spring_sim/scene_reader.h"
#include "scene/tree_reader.h"
#include "scene_text.h"

namespace mass_spring {
namespace {

TEST(EffectsReader, ReadsAndWritesAllOfContactAndDrag) {
  const Scene scene = readScene(sceneWith("effects", R"({
air_drag: {coefficient: 0.01},
contact: {stiffness: 100, thickness: 0.02, friction: 0.3, slip_velocity: 0.002, shapes: {
  table: {type: box, center: [1, 2, 3], size: [0.1, 0.2, 0.3], orientation: [0.1, 0.2, 0.3]},
  bar: {type: capsule, start: [0, 0, 1], end: [0, 1, 1], radius: 0.1},
  ball: {type: sphere, center: [1, 1, 1], radius: 0.5},
  floor: {type: plane, point: [0, 0, -1], normal: [0, 1, 2]}}}})"),
                                "");
  ASSERT_TRUE(scene.effects.contact && scene.effects.air_drag);
  EXPECT_FALSE(scene.effects.gravity);
  EXPECT_EQ(scene.effects.air_drag->coefficient, 0.01);
  const ContactOptions& contact = *scene.effects.contact;
  EXPECT_EQ(contact.stiffness, 100.0);
  EXPECT_EQ(contact.thickness, 0.02);
  EXPECT_EQ(contact.friction, 0.3);
  EXPECT_EQ(contact.slip_velocity, 0.002);
  ASSERT_EQ(contact.shapes.size(), 4u);
  EXPECT_EQ(std::get<Sphere>(contact.shapes[0].geometry).radius, 0.5);  // by name: ball first
  EXPECT_EQ(std::get<Capsule>(contact.shapes[1].geometry).end, Eigen::Vector3d(0, 1, 1));
  EXPECT_EQ(std::get<Plane>(contact.shapes[2].geometry).normal, Eigen::Vector3d(0, 1, 2));
  EXPECT_EQ(std::get<Box>(contact.shapes[3].geometry).orientation, Eigen::Vector3d(0.1, 0.2, 0.3));
  const std::string yaml = toYaml(scene);
  EXPECT_EQ(toYaml(readScene(readYamlText(yaml, "scene"), "")), yaml);
  EXPECT_NE(yaml.find("slip_velocity: 0.002"), std::string::npos) << yaml;
  EXPECT_NE(yaml.find("type: capsule"), std::string::npos) << yaml;
}

TEST(EffectsReader, ReadsAndWritesSelfCollision) {
  const auto read = [](const char* options) {
    return readScene(sceneWith("effects", std::string("{self_collision: ") + options + "}"), "");
  };
  EXPECT_EQ(read("{thickness: 0.01}").effects.self_collision->thickness, 0.01);
  EXPECT_FALSE(read("{thickness: 0.01}").effects.self_collision->stiffness);
  const Scene scene = read("{thickness: 0.02, stiffness: 250}");
  EXPECT_EQ(scene.effects.self_collision->stiffness, 250.0);
  const std::string yaml = toYaml(scene);
  EXPECT_EQ(toYaml(readScene(readYamlText(yaml, "scene"), "")), yaml);
  EXPECT_NE(yaml.find("stiffness: 250"), std::string::npos) << yaml;
}

TEST(EffectsReader, NamesWhatIsWrongAndWhere) {
  const auto problem = [](const std::string& effects) {
    const auto problems = problemsOf(sceneWith("effects", effects));
    return problems.empty() ? "" : problems.front();
  };
  EXPECT_EQ(
      problem("{contact: {stiffness: 10, shapes: {floor: {type: plane, point: [0, 0, 0], "
              "normal: [0, 0, 0]}}}}"),
      "effects.contact.shapes.floor.normal: got a list of 3, expected a direction that is not "
      "0");
  EXPECT_EQ(problem("{contact: {stiffness: 10, shapes: {}}}"),
            "effects.contact.shapes: got an empty map, expected a map of at least one shape");
  EXPECT_EQ(problem("{contact: {stiffness: 10, shapes: {bar: {type: capsule, start: [0, 0, 1], "
                    "end: [0, 0, 1], radius: 0.1}}}}"),
            "effects.contact.shapes.bar.end: got the start, expected another point; for a ball: "
            "type: sphere");
  EXPECT_EQ(problem("{contact: {stiffness: 10, shapes: {1st: {type: sphere, center: [0, 0, 0], "
                    "radius: 1}}}}"),
            std::string("effects.contact.shapes.1st: got 1st, expected ") + kNameRule);
  EXPECT_EQ(problem("{air_drag: {coefficient: -1}}"),
            "effects.air_drag.coefficient: got -1, expected a number >= 0 (N s/m)");
  EXPECT_EQ(problem("{self_collision: {thickness: 0}}"),
            "effects.self_collision.thickness: got 0, expected a number > 0 (m)");
  EXPECT_EQ(problem("{self_collision: {thickness: 0.01, stiffness: -2}}"),
            "effects.self_collision.stiffness: got -2, expected a number > 0 (N/m)");
}

Tree windyScene(const std::string& wind) { return sceneWith("effects.wind", wind); }

TEST(WindReader, ReadsAndWritesAllOfIt) {
  const Scene scene = readScene(windyScene("{velocity: [2, 0, -1], drag: 0.5, lift: 0.1, density: "
                                           "1.1, gust: {amplitude: 0.5, period: 2}}"),
                                "");
  ASSERT_TRUE(scene.effects.wind && scene.effects.wind->gust);
  EXPECT_EQ(scene.effects.wind->velocity, Eigen::Vector3d(2.0, 0.0, -1.0));
  EXPECT_EQ(scene.effects.wind->drag, 0.5);
  EXPECT_EQ(scene.effects.wind->lift, 0.1);
  EXPECT_EQ(scene.effects.wind->density, 1.1);
  EXPECT_EQ(scene.effects.wind->gust->amplitude, 0.5);
  EXPECT_EQ(scene.effects.wind->gust->period, 2.0);
  const std::string yaml = toYaml(scene);
  EXPECT_EQ(toYaml(readScene(readYamlText(yaml, "scene"), "")), yaml);
  EXPECT_NE(yaml.find("      period: 2.0\n"), std::string::npos) << yaml;
}

TEST(WindReader, LeavesOutWhatIsNotThere) {
  const Scene scene = readScene(windyScene("{velocity: [2, 0, 0], drag: 0.5}"), "");
  EXPECT_EQ(scene.effects.wind->lift, 0.0);
  EXPECT_EQ(scene.effects.wind->density, 1.2);
  EXPECT_FALSE(scene.effects.wind->gust);
  const std::string yaml = toYaml(scene);
  EXPECT_EQ(yaml.find("gust"), std::string::npos);
  EXPECT_EQ(toYaml(readScene(readYamlText(yaml, "scene"), "")), yaml);
  EXPECT_EQ(toYaml(readScene(sceneWith("rate", "200.0"), "")).find("wind"), std::string::npos);
}

TEST(WindReader, SaysWhatIsWrong) {
  using Lines = std::vector<std::string>;
  EXPECT_EQ(problemsOf(windyScene("~")),
            (Lines{"effects.wind.velocity: got nothing, expected a list of 3 finite numbers (m/s)",
                   "effects.wind.drag: got nothing, expected a number >= 0"}));
  EXPECT_EQ(problemsOf(windyScene("{velocity: [1, 0, 0], drag: -1, lift: -1, density: 0, gust: "
                                  "{amplitude: -1, period: 0}}")),
            (Lines{"effects.wind.drag: got -1, expected a number >= 0",
                   "effects.wind.lift: got -1, expected a number >= 0",
                   "effects.wind.density: got 0, expected a number > 0 (kg/m^3)",
                   "effects.wind.gust.amplitude: got -1, expected a number >= 0",
                   "effects.wind.gust.period: got 0, expected a number > 0 (s)"}));
  EXPECT_EQ(problemsOf(windyScene("{velocity: [1, 0, 0], drag: 1, gust: 0.5}")),
            Lines{"effects.wind.gust: got 0.5, expected a map with amplitude and period"});
  EXPECT_EQ(
      problemsOf(windyScene("{velocity: [1, 0, 0], drags: 1, drag: 1}")),
      Lines{
          "effects.wind.drags: got an unknown key, expected one of velocity, drag, lift, density, "
          "gust (did you mean 'drag'?)"});
}

TEST(WindReader, RefusesASceneWithNothingToBlowOn) {
  const std::string cable =
      "{type: rope, start: [0, 0, 0], end: [1, 0, 0], segments: 4, mass: 1, "
      "stiffness: 1}";
  const std::string wind = "effects: {wind: {velocity: [1, 0, 0], drag: 1}}\n";
  EXPECT_EQ(
      problemsOf("objects: {cable: " + cable + "}\n" + wind),
      std::vector<std::string>{"effects.wind: got a scene without faces, expected an object of "
                               "type cloth or mesh to blow on"});
  // A sheet that is wrong in another way is no reason to complain about the wind.
  const std::vector<std::string> problems =
      problemsOf("objects: {sheet: {type: cloth, size: [1, 1], mass: 1, stiffness: 1}}\n" + wind);
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_EQ(problems[0].find("objects.sheet.resolution"), 0u) << problems[0];
}

}  // namespace
}  // namespace mass_spring
