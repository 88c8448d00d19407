#pragma once

#include <optional>
#include <string>

#include "mass_spring_sim/tree.h"

namespace mass_spring {

/// What an unquoted scalar means under YAML 1.1, as PyYAML and so rosparam read it: null, bool,
/// integer (decimal, hexadecimal, octal as in 010), float with a dot, deg(x) and rad(x); all else
/// is a string. Numbers in binary, in base 60 or with underscores stay strings, and are so refused
/// wherever a number is wanted.
Tree resolvePlainScalar(const std::string& text);

/// The number that the whole text spells in decimal digits; infinite if it is too large for a
/// double. Nothing for NaN, infinity, blanks or anything else around the number.
std::optional<double> parseNumber(const std::string& text);

/// The shortest text that reads back as the same finite number, and as a float under YAML 1.1: with
/// a dot, and a signed exponent if any.
std::string formatNumber(double number);

}  // namespace mass_spring
