#include "tools/command_line.h"

#include <gtest/gtest.h>

namespace mass_spring {
namespace {

using Words = std::vector<std::string>;

/// A command line with an option of every kind.
CommandLine parsed(std::vector<const char*> words, bool positionals = false) {
  CommandLine line("program", "Does a thing.", "");
  line.addFlag("check", "only check");
  line.addOption("size", "FLOAT", "size");
  line.addOption("check-file", "TEXT", "file");
  line.addRepeated("set", "TEXT", "assignment");
  line.addList("rates", "FLOAT", "rates");
  if (positionals) line.addPositionals("bag", "bags");
  words.insert(words.begin(), "program");
  line.parse(static_cast<int>(words.size()), words.data());
  return line;
}

std::string refusal(const std::vector<const char*>& words, bool positionals = false) {
  try {
    parsed(words, positionals);
  } catch (const ArgumentError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(CommandLine, TakesValuesAfterABlankOrAnEqualSign) {
  for (const auto& words : {std::vector<const char*>{"--size", "2", "--set", "a=1"},
                            std::vector<const char*>{"--size=2", "--set=a=1"}}) {
    const CommandLine line = parsed(words);
    EXPECT_EQ(line.numbers("size", 1.0, 2.0, "a size"), std::vector<double>{2.0});
    EXPECT_EQ(line.value("set"), "a=1");
    EXPECT_FALSE(line.has("check"));
  }
}

TEST(CommandLine, TakesValuesThatLookLikeOptions) {
  EXPECT_EQ(parsed({"--size", "-1"}).value("size"), "-1");
  EXPECT_EQ(parsed({"--set", "--check"}).value("set"), "--check");
  EXPECT_EQ(parsed({"--set", ""}).values("set"), Words{""});
}

TEST(CommandLine, KeepsTheOrderOfRepeatedOptions) {
  EXPECT_EQ(parsed({"--set", "b,c=1", "--check", "--set", "a=2"}).values("set"),
            (Words{"b,c=1", "a=2"}));
  EXPECT_TRUE(parsed({"--check", "--check"}).has("check"));
}

TEST(CommandLine, SplitsListsAtCommasAndBlanks) {
  const Words expected = {"1", "2", "3"};
  EXPECT_EQ(parsed({"--rates", "1,2,3"}).values("rates"), expected);
  EXPECT_EQ(parsed({"--rates", "1", "2,3,"}).values("rates"), expected);
  EXPECT_EQ(parsed({"--rates", "1", "--check", "--rates=2,,3"}).values("rates"), expected);
  EXPECT_EQ(parsed({"--rates", ""}).values("rates"), Words{""});
}

TEST(CommandLine, CollectsPositionals) {
  const Words expected = {"a.bag", "b.bag", "-c.bag"};
  EXPECT_EQ(parsed({"a.bag", "--set", "x", "b.bag", "--", "-c.bag"}, true).values("bag"), expected);
  EXPECT_EQ(refusal({"--check"}, true), "bag is required (see program --help)");
  EXPECT_EQ(refusal({"--bag", "a.bag"}, true),
            "The following argument was not expected: --bag (see program --help)");
}

TEST(CommandLine, RefusesArgumentsThatItDoesNotKnow) {
  for (const char* word : {"stray", "--wings", "-x", "--chec", "--CHECK", "-check"}) {
    EXPECT_EQ(refusal({word}).rfind("The following argument was not expected: ", 0), 0u) << word;
    EXPECT_NE(refusal({word}).find(std::string(word).substr(0, 2)), std::string::npos) << word;
  }
}

TEST(CommandLine, RefusesValuesThatAreMissingOrTooMany) {
  const std::string missing = "--size: 1 required FLOAT missing (see program --help)";
  EXPECT_EQ(refusal({"--size"}), missing);
  EXPECT_EQ(refusal({"--size="}), missing);
  EXPECT_EQ(refusal({"--size", "1", "--size", "2"}),
            "--size: At Most 1 required but received 2 (see program --help)");
  EXPECT_EQ(refusal({"--size", "1", "2"}),
            "The following argument was not expected: 2 (see program --help)");
  EXPECT_NE(refusal({"--check=yes"}).find("--check"), std::string::npos);
}

TEST(CommandLine, RefusesNumbersOutOfRange) {
  for (const char* word : {"", "0.9", "2.1", "1s", "nan", "inf", "1e999"}) {
    const CommandLine line = parsed({"--size", word});
    try {
      line.numbers("size", 1.0, 2.0, "a size");
      ADD_FAILURE() << word << " was accepted";
    } catch (const ArgumentError& error) {
      EXPECT_EQ(error.what(),
                "--size: got " + std::string(word) + ", expected a size (see program --help)");
    }
    EXPECT_THROW(line.integer("size", 1, 2, 1), ArgumentError) << word;
  }
  EXPECT_EQ(parsed({"--size", "18446744073709551615"}).integer("size", 1, ~std::uint64_t{0}, 1),
            ~std::uint64_t{0});
  EXPECT_THROW(parsed({"--size", "18446744073709551616"}).integer("size", 1, ~std::uint64_t{0}, 1),
               ArgumentError);
  EXPECT_EQ(parsed({}).integer("size", 1, 2, 2), 2u);
}

}  // namespace
}  // namespace mass_spring
