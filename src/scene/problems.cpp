#include "scene/problems.h"

#include <algorithm>
#include <numeric>

#include "mass_spring_sim/scene.h"
#include "scene/scalar.h"

namespace mass_spring {
namespace {

constexpr std::size_t kMostProblems = 1000;
constexpr std::size_t kMostWords = 20;
constexpr std::size_t kLongestQuote = 60;

/// Levenshtein's distance: insertions, deletions and replacements of one character.
std::size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row.back();
}

std::string printable(const std::string& text) {
  std::string result;
  for (const char c : text.substr(0, kLongestQuote)) {
    result += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
  }
  return text.size() > kLongestQuote ? result + "..." : result;
}

struct Describe {
  std::string operator()(std::monostate) const { return "nothing"; }
  std::string operator()(bool value) const { return value ? "true" : "false"; }
  std::string operator()(std::int64_t value) const { return std::to_string(value); }
  std::string operator()(double value) const { return formatNumber(value); }
  std::string operator()(const std::string& text) const { return quote(text); }
  std::string operator()(const Tree::List& list) const {
    return list.empty() ? "an empty list" : "a list of " + std::to_string(list.size());
  }
  std::string operator()(const Tree::Map& map) const {
    return map.empty() ? "an empty map" : "a map";
  }
};

}  // namespace

void Problems::add(const std::string& path, const std::string& got, const std::string& expected) {
  ++count_;
  if (full()) return;
  lines_.push_back((path.empty() ? "scene" : path) + ": got " + got + ", expected " + expected);
}

bool Problems::full() const { return count_ > kMostProblems; }

void Problems::throwIfAny() const {
  if (count_ == 0) return;
  std::vector<std::string> lines = lines_;
  if (full()) {
    lines.push_back("scene: got " + std::to_string(count_) + " problems, expected none");
  }
  throw SceneError(std::move(lines));
}

std::string childPath(const std::string& parent, const std::string& key) {
  return parent.empty() ? printable(key) : parent + "." + printable(key);
}

std::string elementPath(const std::string& parent, std::size_t index) {
  return parent + "[" + std::to_string(index) + "]";
}

std::string describe(const Tree& tree) { return std::visit(Describe(), tree.value); }

std::string quote(const std::string& text) { return "'" + printable(text) + "'"; }

std::string listWords(const std::vector<std::string>& words) {
  std::string text;
  const std::size_t shown = std::min(words.size(), kMostWords);
  for (std::size_t i = 0; i < shown; ++i) text += (i == 0 ? "" : ", ") + printable(words[i]);
  if (shown == words.size()) return text;
  return text + " and " + std::to_string(words.size() - shown) + " more";
}

std::string suggest(const std::string& word, const std::vector<std::string>& known) {
  if (word.size() > kLongestQuote) return "";
  const std::string* nearest = nullptr;
  std::size_t distance = 2 + word.size() / 4;  // from here on it is another word, not a slip
  for (const std::string& candidate : known) {
    if (candidate.size() > kLongestQuote) continue;
    const std::size_t d = editDistance(word, candidate);
    if (d >= distance) continue;
    distance = d;
    nearest = &candidate;
  }
  return nearest == nullptr ? "" : " (did you mean " + quote(*nearest) + "?)";
}

}  // namespace mass_spring
