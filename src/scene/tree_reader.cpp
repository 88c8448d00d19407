#include "scene/tree_reader.h"

#include <algorithm>
#include <cmath>

#include "scene/scalar.h"

namespace mass_spring {
namespace {

std::optional<double> toNumber(const Tree& tree) {
  if (const auto* number = std::get_if<double>(&tree.value)) return *number;
  if (const auto* number = std::get_if<std::int64_t>(&tree.value)) return double(*number);
  if (const auto* text = std::get_if<std::string>(&tree.value)) return parseNumber(*text);
  return std::nullopt;
}

}  // namespace

const char* const kNameRule = "a name of letters, digits and _ that begins with a letter";

bool isName(const std::string& text) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  return !text.empty() && is_letter(text[0]) && std::all_of(text.begin(), text.end(), [&](char c) {
    return is_letter(c) || (c >= '0' && c <= '9') || c == '_';
  });
}

bool NumberRule::contains(double number) const {
  if (!std::isfinite(number)) return false;
  return open ? number > low && number < high : number >= low && number <= high;
}

std::string NumberRule::numbers(const std::string& noun) const {
  const auto bound = [](double b) {
    const bool whole = b == std::round(b) && std::abs(b) < 1e6;
    return whole ? std::to_string(static_cast<int>(b)) : formatNumber(b);
  };
  std::string text = noun;
  if (std::isinf(low) && std::isinf(high)) {
    text = "finite " + noun;
  } else if (std::isinf(high)) {
    text += (open ? " > " : " >= ") + bound(low);
  } else {
    text += (open ? " in (" : " in [") + bound(low) + ", " + bound(high) + (open ? ")" : "]");
  }
  return unit.empty() ? text : text + " (" + unit + ")";
}

std::string NumberRule::one() const { return "a " + numbers("number"); }

std::string NumberRule::listOf(std::size_t n) const {
  return "a list of " + std::to_string(n) + " " + numbers("numbers");
}

NumberRule anyNumber(const std::string& unit) { return {unit}; }

NumberRule positive(const std::string& unit) {
  return {unit, 0.0, std::numeric_limits<double>::infinity(), true};
}

NumberRule atLeastZero(const std::string& unit) { return {unit, 0.0}; }

Place::Place(const Tree* tree, std::string path, bool required, Problems& problems)
    : tree_(tree), path_(std::move(path)), required_(required), problems_(&problems) {}

void Place::report(const std::string& got, const std::string& expected) const {
  problems_->add(path_, got, expected);
}

void Place::refuse(const std::string& expected) const {
  report(tree_ == nullptr ? "nothing" : describe(*tree_), expected);
}

bool Place::fail(const std::string& expected) const {
  if (tree_ != nullptr || required_) refuse(expected);
  return false;
}

bool Place::read(bool& target) const {
  const bool* value = as<bool>();
  if (value == nullptr) return fail("true or false");
  target = *value;
  return true;
}

bool Place::read(int& target, int low, int high) const {
  const auto* value = as<std::int64_t>();
  if (value != nullptr && *value >= low && *value <= high) {
    target = static_cast<int>(*value);
    return true;
  }
  std::string expected =
      "an integer in [" + std::to_string(low) + ", " + std::to_string(high) + "]";
  if (as<double>() != nullptr) expected += " without a dot";
  return fail(expected);
}

bool Place::read(double& target, const NumberRule& rule) const {
  const auto number = tree_ == nullptr ? std::nullopt : toNumber(*tree_);
  if (!number || !rule.contains(*number)) return fail(rule.one());
  target = *number;
  return true;
}

bool Place::read(std::optional<double>& target, const NumberRule& rule) const {
  double number = 0.0;
  if (!read(number, rule)) return false;
  target = number;
  return true;
}

bool Place::readNumbers(double* target, std::size_t n, const NumberRule& rule) const {
  const auto* numbers = as<Tree::List>();
  if (numbers == nullptr || numbers->size() != n) return fail(rule.listOf(n));
  bool good = true;
  for (std::size_t i = 0; i < n; ++i) good = element(i).read(target[i], rule) && good;
  return good;
}

bool Place::readOneOrEach(std::vector<double>& target, std::size_t n,
                          const NumberRule& rule) const {
  if (const auto* numbers = as<Tree::List>(); numbers != nullptr && numbers->size() == n) {
    target.resize(n);
    return readNumbers(target.data(), n, rule);
  }
  const auto number = tree_ == nullptr ? std::nullopt : toNumber(*tree_);
  if (!number || !rule.contains(*number)) return fail(rule.one() + ", or " + rule.listOf(n));
  target.assign(n, *number);
  return true;
}

bool Place::read(std::string& target, const std::string& expected) const {
  const auto* text = as<std::string>();
  if (text == nullptr) return fail(expected);
  target = *text;
  return true;
}

bool Place::read(std::size_t& target, const std::vector<std::string>& words) const {
  const auto* word = as<std::string>();
  const std::string expected = "one of " + listWords(words);
  if (word == nullptr) return fail(expected);
  const auto known = std::find(words.begin(), words.end(), *word);
  if (known == words.end()) return fail(expected + suggest(*word, words));
  target = static_cast<std::size_t>(known - words.begin());
  return true;
}

const Tree::List* Place::list(const std::string& expected) const {
  const auto* value = as<Tree::List>();
  if (value == nullptr) fail(expected);
  return value;
}

const Tree::Map* Place::map(const std::string& expected) const {
  static const Tree::Map kEmpty;
  if (as<std::monostate>() != nullptr) return &kEmpty;
  const auto* value = as<Tree::Map>();
  if (value == nullptr) fail(expected);
  return value;
}

Place Place::element(std::size_t index) const {
  return Place(&std::get<Tree::List>(tree_->value)[index], elementPath(path_, index), true,
               *problems_);
}

Place Place::child(const std::string& key, bool required) const {
  const auto* map = as<Tree::Map>();
  const Tree* value = nullptr;
  if (map != nullptr) {
    const auto entry = map->find(key);
    if (entry != map->end()) value = &entry->second;
  }
  return Place(value, childPath(path_, key), required, *problems_);
}

MapReader::MapReader(const Place& place, const std::string& expected)
    : place_(place), map_(place.map(expected)) {}

Place MapReader::keyPlace(const std::string& key, bool required) {
  known_.push_back(key);
  return place_.child(key, required && map_ != nullptr);
}

void MapReader::refuseUnknown() const {
  if (map_ == nullptr) return;
  Problems& problems = place_.problems();
  for (const auto& [key, value] : *map_) {
    if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
    problems.add(childPath(place_.path(), key), "an unknown key",
                 problems.full() ? "" : "one of " + listWords(known_) + suggest(key, known_));
  }
}

}  // namespace mass_spring
