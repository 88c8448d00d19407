#pragma once

#include <chrono>
#include <string>

#include "tools/study_table.h"

namespace mass_spring {

/// Shows how far a study is: a bar with the time that is left on standard error where that is a
/// terminal, and a line per row on standard output.
class StudyProgress {
 public:
  /// @param time_limit  s
  explicit StudyProgress(double time_limit);
  ~StudyProgress();
  StudyProgress(const StudyProgress&) = delete;
  StudyProgress& operator=(const StudyProgress&) = delete;

  double elapsed() const;  ///< s
  double left() const { return time_limit_ - elapsed(); }
  /// @param what  is being done
  void show(const std::string& what);
  void print(const StudyRow& row);

 private:
  using Clock = std::chrono::steady_clock;
  void erase();

  bool terminal_;
  double time_limit_;
  Clock::time_point start_;
};

}  // namespace mass_spring
