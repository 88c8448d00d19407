#include "ros/xmlrpc_tree.h"

#include <gtest/gtest.h>

#include <ctime>
#include <filesystem>
#include <string>

#include "mass_spring_sim/scene_reader.h"

namespace mass_spring {
namespace {

using XmlRpc::XmlRpcValue;

/// What rosparam makes of a tree.
XmlRpcValue fromTree(const Tree& tree) {
  XmlRpcValue value;
  if (const auto* boolean = std::get_if<bool>(&tree.value)) value = *boolean;
  if (const auto* integer = std::get_if<std::int64_t>(&tree.value)) {
    value = static_cast<int>(*integer);
  }
  if (const auto* number = std::get_if<double>(&tree.value)) value = *number;
  if (const auto* text = std::get_if<std::string>(&tree.value)) value = *text;
  if (const auto* list = std::get_if<Tree::List>(&tree.value)) {
    value.setSize(static_cast<int>(list->size()));
    for (int i = 0; i < value.size(); ++i) value[i] = fromTree((*list)[i]);
  }
  if (const auto* map = std::get_if<Tree::Map>(&tree.value)) {
    value.begin();  // a map from now on, also if it is empty
    for (const auto& [key, member] : *map) value[key] = fromTree(member);
  }
  return value;
}

/// As it comes from the parameter server.
XmlRpcValue transmitted(const XmlRpcValue& value) {
  int offset = 0;
  return XmlRpcValue(value.toXml(), &offset);
}

TEST(XmlRpcTree, KeepsTypes) {
  XmlRpcValue value;
  value["boolean"] = true;
  value["integer"] = -7;
  value["number"] = 0.1;
  value["text"] = "1e-4";
  value["list"][0] = 1;
  value["list"][1] = 2.5;
  value["map"]["inner"] = "";

  const Tree tree = toTree(transmitted(value));
  const auto& map = std::get<Tree::Map>(tree.value);
  EXPECT_TRUE(std::get<bool>(map.at("boolean").value));
  EXPECT_EQ(std::get<std::int64_t>(map.at("integer").value), -7);
  EXPECT_EQ(std::get<double>(map.at("number").value), 0.1);
  EXPECT_EQ(std::get<std::string>(map.at("text").value), "1e-4");
  const auto& list = std::get<Tree::List>(map.at("list").value);
  ASSERT_EQ(list.size(), 2u);
  EXPECT_EQ(std::get<std::int64_t>(list[0].value), 1);
  EXPECT_EQ(std::get<double>(list[1].value), 2.5);
  EXPECT_EQ(std::get<std::string>(std::get<Tree::Map>(map.at("map").value).at("inner").value), "");
  EXPECT_EQ(map.size(), 6u);
}

TEST(XmlRpcTree, TurnsWhatNoSceneKnowsIntoText) {
  std::tm date{};
  date.tm_year = 101;
  date.tm_mon = 1;
  date.tm_mday = 3;
  char bytes[] = "abc";
  EXPECT_EQ(std::get<std::string>(toTree(XmlRpcValue(&date)).value), "2001-02-03 00:00:00");
  EXPECT_EQ(std::get<std::string>(toTree(XmlRpcValue(bytes, 3)).value), "abc");
  EXPECT_TRUE(std::holds_alternative<std::monostate>(toTree(XmlRpcValue()).value));
}

TEST(XmlRpcTree, AShippedSceneMeansTheSameOnTheParameterServer) {
  const std::filesystem::path folder =
      std::filesystem::path(MASS_SPRING_SOURCE_DIR) / "config" / "scenes";
  int scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string path = entry.path().string();
    SCOPED_TRACE(path);
    const XmlRpcValue parameters = transmitted(fromTree(readYamlFile(path)));
    EXPECT_EQ(toYaml(readScene(toTree(parameters), folder.string())), toYaml(readSceneFile(path)));
    ++scenes;
  }
  EXPECT_GT(scenes, 0);
}

}  // namespace
}  // namespace mass_spring
