#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "mass_spring_sim/tree.h"
#include "scene/problems.h"

namespace mass_spring {

/// The numbers that a place takes. Only finite ones, whatever the bounds.
struct NumberRule {
  std::string unit;  ///< "" = none
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool open = false;  ///< the bounds themselves are refused

  bool contains(double number) const;
  std::string one() const;                  ///< "a number > 0 (kg)"
  std::string listOf(std::size_t n) const;  ///< "a list of 3 finite numbers (m)"

 private:
  std::string numbers(const std::string& noun) const;
};

NumberRule anyNumber(const std::string& unit);
NumberRule positive(const std::string& unit);
NumberRule atLeastZero(const std::string& unit);

/// One place of a scene: a path and the value there, if any. The read functions return whether they
/// stored a value. They leave the target alone where there is none, and report what is wrong: a
/// value of the wrong kind or range, or none where one is required.
class Place {
 public:
  /// @param tree  must outlive the place; nullptr = nothing there
  Place(const Tree* tree, std::string path, bool required, Problems& problems);

  bool present() const { return tree_ != nullptr; }
  const std::string& path() const { return path_; }
  Problems& problems() const { return *problems_; }
  void report(const std::string& got, const std::string& expected) const;
  /// report(what is there, expected)
  void refuse(const std::string& expected) const;

  bool read(bool& target) const;
  bool read(int& target, int low, int high) const;
  /// An integer, a float, or a string that spells a number as a whole.
  bool read(double& target, const NumberRule& rule) const;
  bool read(std::optional<double>& target, const NumberRule& rule) const;
  /// A list of just that many numbers.
  template <int n>
  bool read(Eigen::Matrix<double, n, 1>& target, const NumberRule& rule) const {
    return readNumbers(target.data(), n, rule);
  }
  bool read(std::string& target, const std::string& expected) const;
  /// One of the words; the target is its place in the list.
  bool read(std::size_t& target, const std::vector<std::string>& words) const;
  /// One number for all, or a list of one for each of n.
  bool readOneOrEach(std::vector<double>& target, std::size_t n, const NumberRule& rule) const;

  /// nullptr if it is no list; reports.
  const Tree::List* list(const std::string& expected) const;
  /// nullptr if it is no map; reports. Null counts as an empty map.
  const Tree::Map* map(const std::string& expected) const;
  Place element(std::size_t index) const;
  Place child(const std::string& key, bool required) const;

 private:
  template <typename T>
  const T* as() const {
    return tree_ == nullptr ? nullptr : std::get_if<T>(&tree_->value);
  }
  /// Refuses what is there, or that nothing is there where something is required. Returns false.
  bool fail(const std::string& expected) const;
  bool readNumbers(double* target, std::size_t n, const NumberRule& rule) const;

  const Tree* tree_;
  std::string path_;
  bool required_;
  Problems* problems_;
};

/// A map with fixed keys. The keys asked for are the keys known.
class MapReader {
 public:
  /// Where the place holds no map, that is reported and every key is silently absent.
  MapReader(const Place& place, const std::string& expected);
  Place required(const std::string& key) { return keyPlace(key, true); }
  Place optional(const std::string& key) { return keyPlace(key, false); }
  /// Reports each key that was not asked for, with the nearest known one.
  void refuseUnknown() const;

 private:
  Place keyPlace(const std::string& key, bool required);

  Place place_;
  const Tree::Map* map_;
  std::vector<std::string> known_;
};

/// [A-Za-z][A-Za-z0-9_]*
bool isName(const std::string& text);
extern const char* const kNameRule;

}  // namespace mass_spring
