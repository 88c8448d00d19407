#include "tools/csv_writer.h"

#include <charconv>

#include "tools/file_error.h"

namespace mass_spring {
namespace {

constexpr std::size_t kBufferSize = 1 << 20;
// The longest: sign, digit, point, 16 digits, e-308; or an integer of 20 digits.
constexpr std::size_t kMaxNumber = 32;

void append(std::uint64_t number, std::string& text) {
  char digits[kMaxNumber];
  text.append(digits, std::to_chars(digits, digits + kMaxNumber, number).ptr);
}

void append(double number, std::string& text) {
  char digits[kMaxNumber];
#ifdef __cpp_lib_to_chars
  // Defined to give the characters of printf, at three times its speed.
  text.append(
      digits,
      std::to_chars(digits, digits + kMaxNumber, number, std::chars_format::general, 17).ptr);
#else
  text.append(digits, std::snprintf(digits, kMaxNumber, "%.17g", number));
#endif
}

}  // namespace

CsvWriter::CsvWriter(const std::string& path) : path_(path), file_(std::fopen(path.c_str(), "w")) {
  if (!file_) throw FileError(path_);
  std::setvbuf(file_.get(), nullptr, _IONBF, 0);  // buffer_ does it
  buffer_.reserve(kBufferSize + 256);
  buffer_ = "step,time,particle,x,y,z,vx,vy,vz\n";
  flush();
}

void CsvWriter::write(const State& state) {
  std::string step_and_time;
  append(state.step, step_and_time);
  step_and_time += ',';
  append(state.time, step_and_time);
  for (Eigen::Index i = 0; i < state.positions.cols(); ++i) {
    buffer_ += step_and_time;
    buffer_ += ',';
    append(static_cast<std::uint64_t>(i), buffer_);
    for (const Vectors* vectors : {&state.positions, &state.velocities}) {
      for (int axis = 0; axis < 3; ++axis) {
        buffer_ += ',';
        append((*vectors)(axis, i), buffer_);
      }
    }
    buffer_ += '\n';
    if (buffer_.size() >= kBufferSize) flush();
  }
}

void CsvWriter::close() {
  flush();
  if (std::fclose(file_.release()) != 0) throw FileError(path_);
}

void CsvWriter::flush() {
  if (std::fwrite(buffer_.data(), 1, buffer_.size(), file_.get()) != buffer_.size())
    throw FileError(path_);
  buffer_.clear();
}

}  // namespace mass_spring
