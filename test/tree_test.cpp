#include "mass_spring_sim/tree.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scene/scalar.h"
#include "scene_text.h"

namespace mass_spring {
namespace {

using Lines = std::vector<std::string>;

Tree parse(const std::string& text) { return readYamlText(text, "text"); }

template <typename T>
const T& as(const Tree& tree) {
  return std::get<T>(tree.value);
}

Lines problems(const std::string& text) {
  try {
    parse(text);
  } catch (const SceneError& error) {
    return error.problems();
  }
  return {};
}

Lines fileProblems(const std::string& path) {
  try {
    readYamlFile(path);
  } catch (const SceneError& error) {
    return error.problems();
  }
  return {};
}

std::string repeat(const std::string& text, int times) {
  std::string result;
  for (int i = 0; i < times; ++i) result += text;
  return result;
}

/// As `python3 -c "import yaml; print(yaml.safe_load(TEXT))"` says, but for the strings at the end.
TEST(Tree, ResolvesPlainScalarsAsYaml11) {
  for (const char* text : {"~", "null", "Null", "NULL", ""}) {
    EXPECT_TRUE(std::holds_alternative<std::monostate>(parse(text).value)) << text;
  }
  for (const char* text : {"yes", "Yes", "YES", "true", "True", "TRUE", "on", "On", "ON"}) {
    EXPECT_TRUE(as<bool>(parse(text))) << text;
  }
  for (const char* text : {"no", "No", "NO", "false", "False", "FALSE", "off", "Off", "OFF"}) {
    EXPECT_FALSE(as<bool>(parse(text))) << text;
  }
  const std::vector<std::pair<const char*, std::int64_t>> integers = {
      {"0", 0},
      {"7", 7},
      {"-12", -12},
      {"+3", 3},
      {"010", 8},
      {"-017", -15},
      {"0x1F", 31},
      {"-0xff", -255},
      {"-0", 0},
      {"00", 0},
      {"9223372036854775807", INT64_MAX}};
  for (const auto& [text, value] : integers) {
    EXPECT_EQ(as<std::int64_t>(parse(text)), value) << text;
  }
  const std::vector<std::pair<const char*, double>> floats = {
      {"1.5", 1.5},       {"-2.", -2.0},          {".5", 0.5},
      {"1.0e+4", 1e4},    {"1.5E-3", 1.5e-3},     {"-.inf", -INFINITY},
      {".INF", INFINITY}, {"1.0e+999", INFINITY}, {"9223372036854775808", 9223372036854775808.0}};
  for (const auto& [text, value] : floats) EXPECT_EQ(as<double>(parse(text)), value) << text;
  EXPECT_TRUE(std::isnan(as<double>(parse(".nan"))));
  for (const char* text :
       {"1e-4", "1e6", "1.0e4", "08", "0x", "0xg", "-", "+", ".", "1.2.3", "1-2", "nan", "inf",
        "0xFFFFFFFFFFFFFFFF", "0x-1", "--1", "y", "n", "yEs", "1,5", "e5", "0-1",
        // PyYAML makes these numbers; here they are refused where one is wanted
        "1_000", "0b11", "1:30", "rad(pi)"}) {
    EXPECT_EQ(as<std::string>(resolvePlainScalar(text)), text);
  }
}

TEST(Tree, ResolvesAnglesAsRosparam) {
  EXPECT_EQ(as<double>(parse("deg(180)")), M_PI);
  EXPECT_EQ(as<double>(parse("deg(-90.0)")), -M_PI / 2);
  EXPECT_EQ(as<double>(parse("rad(1.25)")), 1.25);
}

TEST(Tree, LeavesQuotedScalarsStrings) {
  for (const char* text : {"'1'", "\"1\"", "!!str 1"}) {
    EXPECT_EQ(as<std::string>(parse(text)), "1") << text;
  }
  EXPECT_EQ(as<std::string>(parse("''")), "");
}

TEST(Tree, NumbersAreWrittenAsTheyWereRead) {
  for (const double number :
       {0.0, -0.0, 1.0, 0.1, -9.81, 1e6, 1e22, 1e-4, 1.0 / 3.0, 5e-324, 1.7976931348623157e308}) {
    const std::string text = formatNumber(number);
    const double again = as<double>(parse(text));  // a float under YAML 1.1
    EXPECT_EQ(again, number) << text;
    EXPECT_EQ(std::signbit(again), std::signbit(number)) << text;
  }
  EXPECT_EQ(formatNumber(0.1), "0.1");
  EXPECT_EQ(formatNumber(100.0), "100.0");
  EXPECT_EQ(formatNumber(1e-6), "1.0e-06");
}

TEST(Tree, ReadsListsAndMaps) {
  const Tree tree = parse("b: [1, {c: x}]\na:\n  - - 2\n");
  const auto& map = as<Tree::Map>(tree);
  EXPECT_EQ(map.begin()->first, "a");
  const auto& b = as<Tree::List>(map.at("b"));
  EXPECT_EQ(as<std::int64_t>(b.at(0)), 1);
  EXPECT_EQ(as<std::string>(as<Tree::Map>(b.at(1)).at("c")), "x");
  EXPECT_EQ(as<std::int64_t>(as<Tree::List>(as<Tree::List>(map.at("a")).at(0)).at(0)), 2);
}

TEST(Tree, CopiesAliases) {
  const Tree tree = parse("a: &x [1, 2]\nb: *x\nc: [*x, &y 7, *y]\n");
  const auto& map = as<Tree::Map>(tree);
  EXPECT_EQ(as<Tree::List>(map.at("b")).size(), 2u);
  const auto& c = as<Tree::List>(map.at("c"));
  EXPECT_EQ(as<std::int64_t>(as<Tree::List>(c.at(0)).at(1)), 2);
  EXPECT_EQ(as<std::int64_t>(c.at(2)), 7);
}

TEST(Tree, MergesMapsAsPyYaml) {
  const Tree tree = parse(
      "a: &a {x: 1, y: 1, z: 1}\nb: &b {x: 2, w: 2}\n"
      "one: {y: 0, <<: *a}\ntwo: {<<: [*b, *a], y: 0}\nquoted: {'<<': 5}\n");
  const auto& map = as<Tree::Map>(tree);
  const auto value = [&](const char* of, const char* key) {
    return as<std::int64_t>(as<Tree::Map>(map.at(of)).at(key));
  };
  EXPECT_EQ(value("one", "x"), 1);
  EXPECT_EQ(value("one", "y"), 0);
  EXPECT_EQ(value("two", "x"), 2);
  EXPECT_EQ(value("two", "y"), 0);
  EXPECT_EQ(value("two", "z"), 1);
  EXPECT_EQ(value("two", "w"), 2);
  EXPECT_EQ(value("quoted", "<<"), 5);
  EXPECT_EQ(problems("{<<: 5}"),
            Lines{"text: got 5 for << in line 1, expected a map or a list of maps"});
}

TEST(Tree, RefusesKeysGivenTwice) {
  EXPECT_EQ(problems("rate: 1\nobjects: {a: {mass: 1, mass: 2}}\nrate: 2\nl: [0, {k: 1, k: 1}]"),
            (Lines{"objects.a.mass: got this key again in line 2, expected each key once",
                   "rate: got this key again in line 3, expected each key once",
                   "l[1].k: got this key again in line 4, expected each key once"}));
}

TEST(Tree, RefusesKeysThatAreNoStrings) {
  EXPECT_EQ(problems("on: 1\na: {2: b}"),
            (Lines{"on: got on as a key in line 1, expected a string, so in quotes",
                   "a.2: got 2 as a key in line 2, expected a string, so in quotes"}));
  EXPECT_EQ(problems("? [a]\n: b"),
            Lines{"?: got no string as a key in line 1, expected a string"});
  EXPECT_EQ(problems("'on': 1"), Lines());
}

TEST(Tree, RefusesWhatIsNoYaml) {
  EXPECT_EQ(problems("a: [1, 2\n"),
            Lines{"text: got an error in line 2, column 1 (end of sequence flow not found), "
                  "expected YAML"});
  EXPECT_EQ(problems("a: 1\n b: 2\n").size(), 1u);
  EXPECT_EQ(problems("a: *b\n").size(), 1u);
  EXPECT_EQ(problems("a: !cube 3"),
            Lines{"text: got the tag '!cube' in line 1, expected values without tags"});
  EXPECT_EQ(problems("a: 1\n---\nb: 2\n"),
            Lines{"text: got a second document in line 2, expected one scene in each file"});
  EXPECT_EQ(problems("a: &a [*a]"),
            Lines{"text: got an alias inside what it stands for in line 1, expected a finite "
                  "scene"});
}

TEST(Tree, RefusesBinaryData) {
  const Lines expected = {"text: got binary data, expected YAML"};
  EXPECT_EQ(problems(std::string("a: \0b", 5)), expected);
  EXPECT_EQ(problems("\x7f"
                     "ELF\x02\x01\x01"),
            expected);
  EXPECT_EQ(problems(std::string("\xff\xfe"
                                 "a\0:\0",
                                 6)),
            expected);  // UTF-16
  EXPECT_EQ(problems("\xef\xbb\xbf"
                     "a: 1"),
            Lines());  // UTF-8 with its mark
}

TEST(Tree, RefusesDeepNesting) {
  const auto message = [](int line) {
    return Lines{"text: got lists and maps nested too deeply in line " + std::to_string(line) +
                 ", expected at most 64 levels"};
  };
  EXPECT_EQ(problems(repeat("[", 64) + repeat("]", 64)), Lines());
  EXPECT_EQ(problems(repeat("[", 65) + repeat("]", 65)), message(1));
  EXPECT_EQ(problems(repeat("[", 100000)), message(1));
  EXPECT_EQ(problems(repeat("{a: ", 100000)), message(1));
  EXPECT_EQ(problems(repeat("- ", 100000)), message(1));
  EXPECT_EQ(problems(repeat("? ", 100000)), message(1));
  // Each alias adds one level.
  std::string chain = "a0: &a0 [1]\n";
  for (int i = 1; i < 100; ++i) {
    const std::string number = std::to_string(i), before = std::to_string(i - 1);
    chain += "a" + number + ": &a" + number + " [*a" + before + "]\n";
  }
  EXPECT_EQ(problems(chain), message(64));
}

TEST(Tree, RefusesAliasBombs) {
  std::string bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 30; ++i) {
    const std::string number = std::to_string(i), before = "*a" + std::to_string(i - 1);
    bomb += "a" + number + ": &a" + number + " [" + before + repeat(", " + before, 9) + "]\n";
  }
  EXPECT_EQ(problems(bomb), Lines{"text: got too many values in line 6, expected at most 1000000, "
                                  "aliases included"});
  // Flat, with a single anchor.
  EXPECT_EQ(problems("- &a [" + repeat("1,", 2000) + "1]\n" + repeat("- *a\n", 1000)).size(), 1u);
  EXPECT_EQ(problems("- &a [" + repeat("1,", 2000) + "1]\n" + repeat("- *a\n", 400)).size(), 0u);
}

TEST(Tree, RefusesMoreValuesThanAnySceneNeeds) {
  EXPECT_EQ(problems("[" + repeat("1,", 1000001) + "1]").at(0).substr(0, 25),
            "text: got too many values");
}

TEST(Tree, RefusesFilesThatCannotBeRead) {
  const TemporaryFolder folder;
  EXPECT_EQ(fileProblems(folder.path()),
            Lines{folder.path() + ": got a directory, expected a file"});
  const std::string missing = folder.path() + "/missing.yaml";
  EXPECT_EQ(fileProblems(missing),
            Lines{missing + ": got No such file or directory, expected a YAML file"});
  EXPECT_EQ(fileProblems(folder.write("good.yaml", "a: 1")), Lines());
  EXPECT_EQ(fileProblems(folder.write("empty.yaml", "")), Lines());  // the scene lacks objects then
}

TEST(Tree, RefusesLargeFilesWithoutReadingThem) {
  const TemporaryFolder folder;
  const std::string path = folder.write("large.yaml", "");
  std::filesystem::resize_file(path, 100'000'000);
  EXPECT_EQ(fileProblems(path), Lines{path + ": got too large a file, expected at most 4 MiB"});
  EXPECT_EQ(fileProblems("/dev/zero"),
            Lines{"/dev/zero: got too large a file, expected at most 4 MiB"});
}

}  // namespace
}  // namespace mass_spring
