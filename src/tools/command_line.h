#pragma once

#include <boost/program_options/options_description.hpp>
#include <boost/program_options/variables_map.hpp>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace mass_spring {

/// Arguments that were refused.
class ArgumentError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The arguments of a program: --NAME VALUE or --NAME=VALUE, with names that are spelled in full,
/// and --help. Declare the options, parse, then ask for the values.
class CommandLine {
 public:
  /// The smallest number above 0.
  static constexpr double kAboveZero = std::numeric_limits<double>::denorm_min();

  /// @param purpose  what --help says before the options
  /// @param footer   what --help says after them
  CommandLine(std::string program, std::string purpose, std::string footer);

  /// @param name  without the dashes
  void addFlag(const std::string& name, const std::string& text);
  /// @param type  word for the value in --help, e.g. FLOAT
  void addOption(const std::string& name, const std::string& type, const std::string& text);
  void addRequired(const std::string& name, const std::string& type, const std::string& text);
  /// An option that can be given again, each time with one value.
  void addRepeated(const std::string& name, const std::string& type, const std::string& text);
  /// An option with several values, separated by commas or blanks.
  void addList(const std::string& name, const std::string& type, const std::string& text);
  /// Arguments without a name of which there has to be at least one. Without this call there may
  /// be none.
  void addPositionals(const std::string& name, const std::string& text);

  /// Answers --help on standard output and exits.
  /// @throws ArgumentError  one line that names the argument
  void parse(int argc, const char* const* argv);

  /// Whether the option was given.
  bool has(const std::string& name) const { return given_.count(name) > 0; }
  /// The value of the option; empty if it was not given.
  std::string value(const std::string& name) const;
  /// All values of the option, or the positional arguments, in the order in which they were given.
  std::vector<std::string> values(const std::string& name) const;
  /// The values as numbers.
  /// @param expected  what the error says of a value that is no number in [least, most]
  /// @throws ArgumentError
  std::vector<double> numbers(const std::string& name, double least, double most,
                              const std::string& expected) const;
  /// The value as an integer; `otherwise` if the option was not given.
  /// @throws ArgumentError  it is no integer in [least, most]
  std::uint64_t integer(const std::string& name, std::uint64_t least, std::uint64_t most,
                        std::uint64_t otherwise) const;

  /// An error that points to --help.
  ArgumentError error(const std::string& message) const;

 private:
  struct Option {
    std::string name, type;  ///< without a type: a flag
    bool required = false;
    bool repeated = false;  ///< can be given again
    bool list = false;      ///< takes several values at a time
  };

  void add(Option option, const std::string& text);
  void printHelp() const;
  void store(int argc, const char* const* argv);
  void checkCounts() const;

  std::string program_, purpose_, footer_;
  std::string positional_name_, positional_text_;  ///< empty if there are none
  std::vector<Option> options_;
  boost::program_options::options_description described_;
  boost::program_options::variables_map given_;
  std::vector<std::string> positionals_;
};

}  // namespace mass_spring
