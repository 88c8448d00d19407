#include "tools/command_line.h"

#include <algorithm>
#include <boost/program_options.hpp>
#include <charconv>
#include <cstdlib>
#include <iostream>
#include <utility>

#include "scene/scalar.h"

namespace mass_spring {
namespace {

namespace po = boost::program_options;
using Words = std::vector<std::string>;

constexpr unsigned kHelpWidth = 100;  // columns

/// The fields of "a,b" without the empty ones; text that has no other field is its own.
Words splitAtCommas(const std::string& text) {
  Words fields;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    if (end > begin) fields.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return fields.empty() ? Words{text} : fields;
}

}  // namespace

CommandLine::CommandLine(std::string program, std::string purpose, std::string footer)
    : program_(std::move(program)),
      purpose_(std::move(purpose)),
      footer_(std::move(footer)),
      described_("Options", kHelpWidth) {
  described_.add_options()("help,h", "print this help and exit");
}

/// Boost reads everything as text, any number of times.
void CommandLine::add(Option option, const std::string& text) {
  auto* const words = po::value<Words>()->composing();
  if (option.type.empty()) words->zero_tokens();
  if (option.list) words->multitoken();
  words->value_name(option.type + (option.required ? " REQUIRED" : option.repeated ? " ..." : ""));
  described_.add_options()(option.name.c_str(), words, text.c_str());
  options_.push_back(std::move(option));
}

void CommandLine::addFlag(const std::string& name, const std::string& text) {
  add({name, "", false, true, false}, text);
}

void CommandLine::addOption(const std::string& name, const std::string& type,
                            const std::string& text) {
  add({name, type, false, false, false}, text);
}

void CommandLine::addRequired(const std::string& name, const std::string& type,
                              const std::string& text) {
  add({name, type, true, false, false}, text);
}

void CommandLine::addRepeated(const std::string& name, const std::string& type,
                              const std::string& text) {
  add({name, type, false, true, false}, text);
}

void CommandLine::addList(const std::string& name, const std::string& type,
                          const std::string& text) {
  add({name, type, false, true, true}, text);
}

void CommandLine::addPositionals(const std::string& name, const std::string& text) {
  positional_name_ = name;
  positional_text_ = text;
}

void CommandLine::printHelp() const {
  const std::string& name = positional_name_;
  std::cout << purpose_ << "\nUsage: " << program_ << " [OPTIONS]"
            << (name.empty() ? "" : ' ' + name + "...") << "\n\n";
  if (!name.empty()) {
    std::cout << "Positionals:\n  " << name << " ... REQUIRED  " << positional_text_ << "\n\n";
  }
  std::cout << described_;
  if (!footer_.empty()) std::cout << '\n' << footer_ << '\n';
}

void CommandLine::store(int argc, const char* const* argv) {
  try {
    const po::parsed_options parsed =
        po::command_line_parser(argc, argv)
            .options(described_)
            .style(po::command_line_style::unix_style & ~po::command_line_style::allow_guessing)
            .run();
    po::store(parsed, given_);
    for (const po::option& option : parsed.options) {
      if (!option.string_key.empty()) continue;
      for (const std::string& word : option.value) {
        if (positional_name_.empty()) {
          throw error("The following argument was not expected: " + word);
        }
        positionals_.push_back(word);
      }
    }
  } catch (const po::unknown_option& unknown) {
    throw error("The following argument was not expected: " + unknown.get_option_name());
  } catch (const po::invalid_command_line_syntax& syntax) {
    const std::string name = syntax.get_option_name();
    for (const Option& option : options_) {
      if (name == "--" + option.name && !option.type.empty()) {
        throw error(name + ": 1 required " + option.type + " missing");
      }
    }
    throw error(syntax.what());
  } catch (const po::error& refused) {
    throw error(refused.what());
  }
}

void CommandLine::checkCounts() const {
  for (const Option& option : options_) {
    const std::size_t count = option.type.empty() ? 0 : values(option.name).size();
    if (option.required && count == 0) throw error("--" + option.name + " is required");
    if (!option.repeated && count > 1) {
      throw error("--" + option.name + ": At Most 1 required but received " +
                  std::to_string(count));
    }
  }
  if (!positional_name_.empty() && positionals_.empty()) {
    throw error(positional_name_ + " is required");
  }
}

void CommandLine::parse(int argc, const char* const* argv) {
  store(argc, argv);
  if (has("help")) {
    printHelp();
    std::exit(0);
  }
  checkCounts();
}

std::string CommandLine::value(const std::string& name) const {
  const Words all = values(name);
  return all.empty() ? "" : all.front();
}

Words CommandLine::values(const std::string& name) const {
  if (name == positional_name_) return positionals_;
  if (!has(name)) return {};
  const auto& words = given_[name].as<Words>();
  for (const Option& option : options_) {
    if (option.name != name || !option.list) continue;
    Words fields;
    for (const std::string& word : words) {
      for (const std::string& field : splitAtCommas(word)) fields.push_back(field);
    }
    return fields;
  }
  return words;
}

std::vector<double> CommandLine::numbers(const std::string& name, double least, double most,
                                         const std::string& expected) const {
  std::vector<double> result;
  for (const std::string& text : values(name)) {
    const std::optional<double> number = parseNumber(text);
    if (!number || *number < least || *number > most) {
      throw error("--" + name + ": got " + text + ", expected " + expected);
    }
    result.push_back(*number);
  }
  return result;
}

std::uint64_t CommandLine::integer(const std::string& name, std::uint64_t least, std::uint64_t most,
                                   std::uint64_t otherwise) const {
  if (!has(name)) return otherwise;
  const std::string text = value(name);
  std::uint64_t number = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, problem] = std::from_chars(text.data(), end, number);
  if (problem != std::errc() || rest != end || number < least || number > most) {
    throw error("--" + name + ": Value " + text + " not in range " + std::to_string(least) +
                " to " + std::to_string(most));
  }
  return number;
}

ArgumentError CommandLine::error(const std::string& message) const {
  return ArgumentError(message + " (see " + program_ + " --help)");
}

}  // namespace mass_spring
