#pragma once

#include <cstdio>
#include <memory>
#include <string>

#include "mass_spring_sim/state.h"

namespace mass_spring {

/// Writes states as CSV, one line per particle, all doubles with 17 significant digits: enough for
/// every double to be read back exactly.
class CsvWriter {
 public:
  /// Creates the file and writes the header through to it.
  /// @throws FileError
  explicit CsvWriter(const std::string& path);

  /// @throws FileError  e.g. when the disk is full
  void write(const State& state);

  /// Writes what is still in memory and closes the file.
  /// @throws FileError
  void close();

 private:
  void flush();

  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::string path_;
  std::unique_ptr<std::FILE, Closer> file_;
  std::string buffer_;
};

}  // namespace mass_spring
