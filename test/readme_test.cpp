// The pages against the code and against one another.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <variant>
#include <vector>

#include "mass_spring_sim/scene_reader.h"
#include "mass_spring_sim/simulation.h"
#include "scene_text.h"

namespace mass_spring::pages {
namespace {

namespace fs = std::filesystem;

const fs::path kSource = MASS_SPRING_SOURCE_DIR;

std::string textOf(const fs::path& path) {
  std::ifstream file(path);
  EXPECT_TRUE(file) << path;
  std::stringstream content;
  content << file.rdbuf();
  return content.str();
}

std::vector<std::string> linesOf(const fs::path& path) {
  std::istringstream text(textOf(path));
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

/// The files of a folder and below it that have one of the extensions.
std::vector<fs::path> filesIn(const fs::path& folder, const std::set<std::string>& extensions) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (extensions.count(entry.path().extension().string()) > 0) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<fs::path> pages() {
  std::vector<fs::path> found = filesIn(kSource / "docs", {".md"});
  for (const char* page : {"README.md", "CONTRIBUTING.md", "benchmark/README.md"}) {
    found.push_back(kSource / page);
  }
  return found;
}

std::vector<std::string> matches(const std::string& text, const std::string& pattern) {
  static std::map<std::string, std::regex> compiled;
  const std::regex& regex = compiled.try_emplace(pattern, pattern).first->second;
  std::vector<std::string> found;
  for (std::sregex_iterator match(text.begin(), text.end(), regex), end; match != end; ++match) {
    found.push_back((*match)[1]);
  }
  return found;
}

TEST(Pages, LinksResolve) {
  for (const fs::path& page : pages()) {
    std::size_t links = 0;
    for (const std::string& link : matches(textOf(page), R"(\]\(([^)#\s]+)[^)]*\))")) {
      if (link.rfind("http", 0) == 0) continue;
      EXPECT_TRUE(fs::exists(page.parent_path() / link)) << page << " links to " << link;
      ++links;
    }
    EXPECT_TRUE(links > 0 || page.filename() != "README.md") << page;
  }
}

TEST(Pages, ReadmeIsShortAndLinksToEachPage) {
  EXPECT_LE(linesOf(kSource / "README.md").size(), 150u);
  const std::string readme = textOf(kSource / "README.md");
  for (const auto& entry : fs::directory_iterator(kSource / "docs")) {
    if (entry.path().extension() != ".md") continue;
    const std::string name = entry.path().filename().string();
    EXPECT_NE(readme.find("\n| [" + entry.path().stem().string() + "](docs/" + name + ") |"),
              std::string::npos)
        << name << " is not in the README's table";
  }
}

std::vector<std::string> cellsOf(const std::string& row) {
  std::vector<std::string> cells;
  std::string cell;
  for (std::size_t k = 1; k < row.size(); ++k) {
    if (row[k] == '|' && row[k - 1] != '\\') {
      const std::size_t begin = cell.find_first_not_of(' '), end = cell.find_last_not_of(' ');
      cells.push_back(begin == std::string::npos ? "" : cell.substr(begin, end - begin + 1));
      cell.clear();
    } else {
      cell += row[k];
    }
  }
  return cells;
}

/// The comments of a source file; lines of comments that follow one another are one.
std::vector<std::string> commentsOf(const fs::path& source) {
  std::vector<std::string> comments(1);
  for (const std::string& line : linesOf(source)) {
    const std::size_t slashes = line.find("//");
    if (slashes != std::string::npos) {
      const std::size_t begin = line.find_first_not_of("/ ", slashes);
      if (begin != std::string::npos) comments.back() += line.substr(begin) + ' ';
    } else if (!comments.back().empty()) {
      comments.emplace_back();
    }
  }
  return comments;
}

// The sources that comments cite are in docs/references.md.
TEST(Pages, ReferencesHaveAllCitations) {
  std::set<std::string> equations;                          // of the course notes
  std::map<std::string, std::vector<std::string>> authors;  // by year
  for (const std::string& line : linesOf(kSource / "docs/references.md")) {
    if (line.rfind("| ", 0) != 0) continue;
    const std::string source = cellsOf(line).front();
    const auto years = matches(source, R"((\d{4})$)");
    const auto words = matches(source, years.empty() ? R"(\b(\d+)\b)" : R"(\b([A-Z]\w+))");
    if (years.empty()) {
      equations.insert(words.begin(), words.end());
    } else {
      auto& names = authors[years.front()];
      names.insert(names.end(), words.begin(), words.end());
    }
  }
  std::size_t cited_equations = 0, cited_papers = 0;
  for (const char* folder : {"src", "include", "benchmark"}) {
    for (const fs::path& source : filesIn(kSource / folder, {".h", ".cpp"})) {
      for (const std::string& comment : commentsOf(source)) {
        const auto names = [&](const std::string& name) {
          return comment.find(name) != std::string::npos;
        };
        if (!names("Macklin")) {  // whose equations are another matter
          for (const std::string& equation : matches(comment, R"((?:eq\. |eq\. \d+[-/])(\d+))")) {
            ++cited_equations;
            EXPECT_EQ(equations.count(equation), 1u) << source << ": " << comment;
          }
        }
        for (const std::string& year : matches(comment, R"(\b(19[4-9]\d|20[0-2]\d)\b)")) {
          if (names("since " + year)) continue;  // no citation
          ++cited_papers;
          EXPECT_TRUE(std::any_of(authors[year].begin(), authors[year].end(), names))
              << source << " cites somebody of " << year << ": " << comment;
        }
      }
    }
  }
  // Otherwise the patterns above find nothing any more.
  EXPECT_GT(cited_equations, 5u);
  EXPECT_GT(cited_papers, 15u);
}

// --- docs/scene.md against the reader ------------------------------------------------------------

/// A row of a table of keys. `path` is where the key is in the page's complete scene.
struct Row {
  std::string path, unit, range, default_value;
};

std::string scenePage() { return textOf(kSource / "docs/scene.md"); }

Tree completeScene() {
  const std::string text = scenePage();
  const std::string fence = "```yaml\n";
  const std::size_t begin = text.find(fence) + fence.size();
  const std::size_t end = text.find("```", begin);
  return readYamlText(text.substr(begin, end - begin), "scene.md");
}

/// The complete scene, without the mesh where that does not matter: reading it takes its time.
Tree sceneFor(const std::string& path) {
  static const Tree complete = completeScene();
  Tree tree = complete;
  if (path.rfind("objects.skin", 0) != 0) put(tree, "objects.skin", kRemoved);
  return tree;
}

/// The headings name the place that a table is about: (`objects.cable`).
std::vector<Row> rowsOfScenePage() {
  std::vector<Row> rows;
  std::string prefix;
  for (const std::string& line : linesOf(kSource / "docs/scene.md")) {
    if (line.rfind("#", 0) == 0) {
      const auto found = matches(line, R"(\(`([^`]+)`\))");
      prefix = found.empty() ? "" : found.front() + ".";
      // Any object will do; a rope has a color in the complete scene.
      if (prefix == "objects.NAME.") prefix = "objects.cable.";
    }
    const auto keys = matches(line, R"(^\| `(\w+)` \|)");
    if (keys.empty()) continue;
    const auto cells = cellsOf(line);
    EXPECT_EQ(cells.size(), 5u) << line;
    if (cells.size() == 5u) rows.push_back({prefix + keys.front(), cells[2], cells[3], cells[4]});
  }
  return rows;
}

/// a.b[0].c as {"a", "b", "0", "c"}
std::vector<std::string> stepsOf(const std::string& path) { return matches(path, R"((\w+))"); }

/// The place in a tree; nullptr if there is none.
Tree* find(Tree& tree, const std::vector<std::string>& steps) {
  Tree* place = &tree;
  for (const std::string& step : steps) {
    if (auto* list = std::get_if<Tree::List>(&place->value)) {
      place = &list->at(std::stoul(step));
    } else if (auto* map = std::get_if<Tree::Map>(&place->value)) {
      const auto entry = map->find(step);
      if (entry == map->end()) return nullptr;
      place = &entry->second;
    } else {
      return nullptr;
    }
  }
  return place;
}

void erase(Tree& tree, const std::string& path) { put(tree, path, kRemoved); }

/// Makes room for a key beside which another one may not stand, or that needs another one.
void makeRoomFor(const std::string& path, Tree& tree) {
  if (path == "objects.cable.axial_rigidity") erase(tree, "objects.cable.stiffness");
  const std::string pin = "timeline[1].pin.";
  if (path != pin + "point" && path != pin + "radius") return;
  erase(tree, pin + "particles");
  put(tree, pin + "point", "[0.0, 0.0, 0.0]");
}

/// Puts a number there: into the first place of a list.
void putNumber(Tree& tree, const std::string& path, const std::string& number) {
  static const std::set<std::string> kVectors = {"point", "target", "position", "orientation"};
  const Tree* place = find(tree, stepsOf(path));
  if (place != nullptr && std::holds_alternative<Tree::List>(place->value)) {
    put(tree, path + "[0]", number);
  } else if (kVectors.count(stepsOf(path).back()) > 0) {
    put(tree, path, '[' + number + ", 0.0, 0.0]");
  } else {
    put(tree, path, number);
  }
}

/// The problem that is told of a place, or of one inside it.
std::optional<std::string> problemAt(const Tree& tree, const std::string& path) {
  for (const std::string& problem : problemsOf(tree, kSource.string())) {
    if (problem.rfind(path, 0) != 0) continue;
    if (problem[path.size()] == ':' || problem[path.size()] == '[') return problem;
  }
  return std::nullopt;
}

/// Numbers that a range of the page takes, and others that it does not.
struct Samples {
  std::vector<double> good, bad;
};

std::optional<Samples> samplesOf(const std::string& range) {
  std::smatch match;
  if (range == "any") return Samples{{-1.0, 1.0}, {}};
  if (std::regex_match(range, match, std::regex(R"((>=?) (\S+))"))) {
    const double low = std::stod(match[2]);
    if (match[1] == ">=") return Samples{{low, low + 1.0}, {low - 1.0}};
    return Samples{{low + 1.0}, {low, low - 1.0}};
  }
  if (std::regex_search(range, match, std::regex(R"(^([\[(])(\S+), ([^\])]+)[\])])"))) {
    const double low = std::stod(match[2]), high = std::stod(match[3]);
    if (match[1] == "[") return Samples{{low, high}, {low - 1.0, high + 1.0}};
    return Samples{{(low + high) / 2.0}, {low, high}};
  }
  return std::nullopt;
}

/// As YAML: whole numbers also serve where an integer is wanted.
std::string yamlOf(double number) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(number == std::floor(number) ? 0 : 6) << number;
  return text.str();
}

TEST(ScenePage, CompleteSceneRuns) {
  Simulation simulation(readScene(completeScene(), kSource.string()));
  EXPECT_EQ(simulation.model().objects.size(), 5u);
  for (int n = 0; n < 5; ++n) EXPECT_EQ(simulation.step().status, StepStatus::kConverged);
}

TEST(ScenePage, RangesAndUnitsAreThoseOfTheReader) {
  std::size_t checked = 0;
  for (const Row& row : rowsOfScenePage()) {
    const auto samples = samplesOf(row.range);
    if (!samples) {
      EXPECT_TRUE(row.range == "" || row.range == "see below" || row.range == "true, false")
          << row.path << ": " << row.range;
      continue;
    }
    ++checked;
    const auto problemWith = [&](const std::string& number) {
      Tree tree = sceneFor(row.path);
      makeRoomFor(row.path, tree);
      putNumber(tree, row.path, number);
      return problemAt(tree, row.path);
    };
    for (double number : samples->good) {
      EXPECT_EQ(problemWith(yamlOf(number)), std::nullopt) << row.path << " = " << number;
    }
    std::vector<std::string> bad = {".nan"};
    for (double number : samples->bad) bad.push_back(yamlOf(number));
    // kg/m³ is written (kg/m^3) in messages.
    std::string unit = std::regex_replace(row.unit, std::regex("²"), "^2");
    unit = std::regex_replace(unit, std::regex("³"), "^3");
    for (const std::string& number : bad) {
      const auto problem = problemWith(number);
      ASSERT_TRUE(problem) << row.path << " takes " << number << ", unlike " << row.range;
      if (unit.empty()) continue;
      const std::size_t place = problem->rfind('(' + unit);
      ASSERT_NE(place, std::string::npos) << row.path << " [" << unit << "]: " << *problem;
      const char next = (*problem)[place + 1 + unit.size()];
      EXPECT_TRUE(next == ')' || next == ',' || next == ' ') << row.path << ": " << *problem;
    }
  }
  EXPECT_GT(checked, 80u);
}

TEST(ScenePage, DefaultsAreThoseOfTheReader) {
  std::size_t checked = 0;
  for (const Row& row : rowsOfScenePage()) {
    Tree tree = sceneFor(row.path);
    if (row.default_value != "absent") makeRoomFor(row.path, tree);
    erase(tree, row.path);
    if (row.default_value.rfind("required", 0) == 0) {
      EXPECT_TRUE(problemAt(tree, row.path)) << row.path << " is not required";
      ++checked;
      continue;
    }
    std::smatch match;
    const bool absent = row.default_value == "absent";
    const bool value = std::regex_match(row.default_value, match,
                                        std::regex(R"(`?([-+.\w]+|\[[^\]]*\])`?(;.*)?)"));
    if (!absent && !value) continue;  // in words
    ASSERT_EQ(problemsOf(tree, kSource.string()), std::vector<std::string>()) << row.path;
    Tree resolved = readYamlText(toYaml(readScene(tree, kSource.string())), "resolved");
    const Tree* found = find(resolved, stepsOf(row.path));
    ++checked;
    if (absent) {
      EXPECT_EQ(found, nullptr) << row.path << " has a default";
      continue;
    }
    ASSERT_NE(found, nullptr) << row.path;
    // As the reader of YAML sees both.
    Tree expected = readYamlText("v: " + match[1].str(), "default");
    const auto render = [](const Tree& scalar) {
      if (const auto* text = std::get_if<std::string>(&scalar.value)) return *text;
      if (const auto* number = std::get_if<double>(&scalar.value)) return std::to_string(*number);
      if (const auto* integer = std::get_if<std::int64_t>(&scalar.value)) {
        return std::to_string(static_cast<double>(*integer));
      }
      const auto* flag = std::get_if<bool>(&scalar.value);
      return std::string(flag == nullptr ? "neither" : *flag ? "true" : "false");
    };
    const Tree& wanted = *find(expected, {"v"});
    if (const auto* list = std::get_if<Tree::List>(&wanted.value)) {
      const auto& got = std::get<Tree::List>(found->value);
      ASSERT_EQ(got.size(), list->size()) << row.path;
      for (std::size_t k = 0; k < got.size(); ++k) {
        EXPECT_EQ(render(got[k]), render((*list)[k])) << row.path;
      }
    } else {
      EXPECT_EQ(render(*found), render(wanted)) << row.path;
    }
  }
  EXPECT_GT(checked, 90u);
}

/// Puts a key that nobody knows into each map whose keys are not names.
void spoil(Tree& tree, const std::string& path) {
  static const std::regex kNames(R"((objects|pins|effects\.contact\.shapes))");
  if (auto* list = std::get_if<Tree::List>(&tree.value)) {
    for (std::size_t k = 0; k < list->size(); ++k) {
      spoil((*list)[k], path + '[' + std::to_string(k) + ']');
    }
  } else if (auto* map = std::get_if<Tree::Map>(&tree.value)) {
    for (auto& [key, value] : *map) spoil(value, path.empty() ? key : path + '.' + key);
    if (!std::regex_match(path, kNames)) (*map)["zz"] = Tree{0.0};
  }
}

// The reader names all keys that it knows beside the one that it does not.
TEST(ScenePage, KeysAreThoseOfTheReader) {
  std::map<std::string, std::set<std::string>> explained;  // by place
  for (const Row& row : rowsOfScenePage()) {
    const std::size_t dot = row.path.rfind('.');
    explained[dot == std::string::npos ? "" : row.path.substr(0, dot + 1)].insert(
        row.path.substr(dot == std::string::npos ? 0 : dot + 1));
  }
  // Of the headings, some serve several places: those of every object, effect and pin.
  const auto& rope = explained["objects.cable."];
  Tree tree = completeScene();
  spoil(tree, "");
  std::size_t places = 0;
  for (const std::string& problem : problemsOf(tree, kSource.string())) {
    std::smatch match;
    if (!std::regex_search(
            problem, match,
            std::regex(R"(^(\S*)zz: got an unknown key, expected one of ([^(]*))"))) {
      continue;
    }
    ++places;
    const std::string place = match[1];
    const auto keys = matches(match[2], R"((\w+))");
    if (place == "effects.") {  // a heading each
      for (const std::string& key : keys) {
        EXPECT_GT(explained.count("effects." + key + "."), 0u) << key;
      }
      continue;
    }
    const std::string like =
        std::regex_replace(place, std::regex(R"(timeline\[\d+\]\.$)"), "timeline[0].");
    std::set<std::string> known = explained[like];
    if (std::regex_match(place, std::regex(R"(objects\.\w+\.)"))) {
      for (const char* common : {"type", "color"}) {
        if (rope.count(common) > 0) known.insert(common);
      }
    }
    EXPECT_EQ(known, std::set<std::string>(keys.begin(), keys.end())) << place;
  }
  EXPECT_GT(places, 20u);
}

}  // namespace
}  // namespace mass_spring::pages
