#pragma once

#include <string>
#include <vector>

#include "mass_spring_sim/tree.h"

namespace mass_spring {

/// What was found wrong with a scene so far, each `path: got X, expected Y`.
class Problems {
 public:
  void add(const std::string& path, const std::string& got, const std::string& expected);
  std::size_t count() const { return count_; }
  /// Further problems are only counted: nobody reads thousands of lines.
  bool full() const;
  /// @throws SceneError
  void throwIfAny() const;

 private:
  std::vector<std::string> lines_;
  std::size_t count_ = 0;
};

/// The path of a key or of an element below another path.
std::string childPath(const std::string& parent, const std::string& key);
std::string elementPath(const std::string& parent, std::size_t index);

/// A value for the eye: a number, 'text', "a list of 3", "a map".
std::string describe(const Tree& tree);
/// The text in quotes, printable and not too long.
std::string quote(const std::string& text);
/// "a, b, c"; long lists end in "and 12 more".
std::string listWords(const std::vector<std::string>& words);
/// " (did you mean 'stiffness'?)", or "" where no known word is near.
std::string suggest(const std::string& word, const std::vector<std::string>& known);

}  // namespace mass_spring
