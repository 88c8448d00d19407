#include "scene/scalar.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <locale>
#include <sstream>

namespace mass_spring {
namespace {

constexpr double kPi = 3.14159265358979323846;
// A double has at most 767 significant digits, and no one writes that many.
constexpr std::size_t kLongestNumber = 400;

bool isOneOf(const std::string& text, std::initializer_list<const char*> words) {
  return std::find(words.begin(), words.end(), text) != words.end();
}

std::optional<Tree> resolveInteger(const std::string& sign, std::string digits) {
  int base = 10;
  if (digits.size() > 2 && digits.compare(0, 2, "0x") == 0) {
    base = 16;
    digits.erase(0, 2);
  } else if (digits.size() > 1 && digits[0] == '0') {
    base = 8;
  }
  if (digits.empty() || digits[0] == '-') return std::nullopt;
  const std::string signed_digits = (sign == "-" ? "-" : "") + digits;
  const char* end = signed_digits.data() + signed_digits.size();
  std::int64_t value = 0;
  const auto [rest, error] = std::from_chars(signed_digits.data(), end, value, base);
  if (rest != end) return std::nullopt;
  if (error == std::errc()) return Tree{value};
  // Beyond 64 bits: no integer that a scene could use, but still a number.
  const auto large = parseNumber(signed_digits);
  return large && base == 10 ? std::optional(Tree{*large}) : std::nullopt;
}

std::optional<Tree> resolveFloat(const std::string& text, const std::string& sign,
                                 const std::string& body) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (isOneOf(body, {".inf", ".Inf", ".INF"})) return Tree{sign == "-" ? -kInfinity : kInfinity};
  if (isOneOf(text, {".nan", ".NaN", ".NAN"})) {
    return Tree{std::numeric_limits<double>::quiet_NaN()};
  }
  if (text.find('.') == std::string::npos) return std::nullopt;
  const std::size_t exponent = text.find_first_of("eE");
  if (exponent != std::string::npos &&
      text.find_first_of("+-", exponent) != exponent + 1) {  // YAML 1.1 wants the sign
    return std::nullopt;
  }
  const auto number = parseNumber(text);
  if (!number) return std::nullopt;
  return Tree{*number};
}

/// rosparam's own deg(90) and rad(1.57).
std::optional<Tree> resolveAngle(const std::string& text) {
  const bool degrees = text.compare(0, 4, "deg(") == 0;
  if (text.back() != ')' || !(degrees || text.compare(0, 4, "rad(") == 0)) return std::nullopt;
  const auto number = parseNumber(text.substr(4, text.size() - 5));
  if (!number) return std::nullopt;
  return Tree{degrees ? *number * kPi / 180.0 : *number};
}

}  // namespace

Tree resolvePlainScalar(const std::string& text) {
  if (text.empty() || isOneOf(text, {"~", "null", "Null", "NULL"})) return {};
  if (isOneOf(text, {"yes", "Yes", "YES", "true", "True", "TRUE", "on", "On", "ON"})) {
    return {true};
  }
  if (isOneOf(text, {"no", "No", "NO", "false", "False", "FALSE", "off", "Off", "OFF"})) {
    return {false};
  }
  if (text.size() > kLongestNumber) return {text};
  const std::string sign = text[0] == '-' || text[0] == '+' ? text.substr(0, 1) : "";
  const std::string body = text.substr(sign.size());
  if (const auto integer = resolveInteger(sign, body)) return *integer;
  if (const auto number = resolveFloat(text, sign, body)) return *number;
  if (const auto angle = resolveAngle(text)) return *angle;
  return {text};
}

std::optional<double> parseNumber(const std::string& text) {
  if (text.empty() || text.size() > kLongestNumber) return std::nullopt;
  // A stream of the classic locale, because strtod follows the locale of the program.
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  double number = 0.0;
  stream >> std::noskipws >> number;
  const bool overflow = stream.fail() && std::abs(number) == std::numeric_limits<double>::max();
  if (stream.fail() && !overflow) return std::nullopt;
  stream.clear();
  if (stream.peek() != std::istringstream::traits_type::eof()) return std::nullopt;
  if (overflow) return std::copysign(std::numeric_limits<double>::infinity(), number);
  return number;
}

std::string formatNumber(double number) {
  std::string text;
  for (int digits = std::numeric_limits<double>::digits10;
       digits <= std::numeric_limits<double>::max_digits10; ++digits) {
    std::ostringstream stream;
    stream.imbue(std::locale::classic());
    stream.precision(digits);
    stream << number;
    text = stream.str();
    if (parseNumber(text) == number) break;
  }
  if (!std::isfinite(number) || text.find('.') != std::string::npos) return text;
  const std::size_t exponent = text.find('e');
  return exponent == std::string::npos ? text + ".0" : text.insert(exponent, ".0");
}

}  // namespace mass_spring
