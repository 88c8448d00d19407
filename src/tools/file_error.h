#pragma once

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>

namespace mass_spring {

/// A file that could not be written; names it and what the system said last.
class FileError : public std::runtime_error {
 public:
  explicit FileError(const std::string& path)
      : std::runtime_error("cannot write " + path + ": " + std::strerror(errno)) {}
};

}  // namespace mass_spring
