#include "tools/study_table.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <istream>
#include <sstream>
#include <stdexcept>

namespace mass_spring {
namespace {

constexpr const char* kHeader =
    "scheme,rate,substeps,newton_tolerance,rms_error_m,max_error_m,energy_error_j,wall_seconds,"
    "step_median_s,status,accuracy_m,momentum_error_kg_m_s,end_energy_j,end_height_m,steps,"
    "substeps_total,newton_iterations,linear_iterations,factorizations,unconverged_steps,"
    "mode_frequency_error,mode_damping_error";
constexpr std::size_t kColumns = 22;

/// All digits of a double; nothing where there is none.
std::string allDigits(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}
std::string allDigits(const std::optional<double>& value) { return value ? allDigits(*value) : ""; }

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> fields(1);
  for (const char c : line) {
    if (c == ',') {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  return fields;
}

double toNumber(const std::string& text) {
  std::size_t used = 0;
  const double value = std::stod(text, &used);  // throws std::invalid_argument
  if (used != text.size()) throw std::invalid_argument(text);
  return value;
}
std::optional<double> toOptional(const std::string& text) {
  return text.empty() ? std::nullopt : std::optional<double>(toNumber(text));
}

StudyRow parse(const std::vector<std::string>& fields) {
  StudyRow row;
  const std::optional<Scheme> scheme = schemeFromName(fields[0]);
  if (!scheme) throw std::invalid_argument(fields[0]);
  row.setting = {*scheme, toNumber(fields[1]), static_cast<int>(toNumber(fields[2])),
                 toOptional(fields[3]), toOptional(fields[10])};
  row.rms_error = toNumber(fields[4]);
  row.max_error = toNumber(fields[5]);
  row.energy_error = toNumber(fields[6]);
  row.wall_seconds = toNumber(fields[7]);
  row.step_median = toNumber(fields[8]);
  row.status = fields[9];
  row.momentum_error = toNumber(fields[11]);
  row.end_energy = toNumber(fields[12]);
  row.end_height = toNumber(fields[13]);
  std::uint64_t* const counts[] = {&row.totals.steps,
                                   &row.totals.substeps,
                                   &row.totals.newton_iterations,
                                   &row.totals.linear_iterations,
                                   &row.totals.factorizations,
                                   &row.totals.unconverged_steps};
  for (std::size_t k = 0; k < 6; ++k) *counts[k] = std::stoull(fields[14 + k]);
  if (!fields[20].empty()) row.mode_errors = {toNumber(fields[20]), toNumber(fields[21])};
  return row;
}

template <typename Good>
const StudyRow* cheapestOf(const std::vector<StudyRow>& rows, Good good) {
  const StudyRow* best = nullptr;
  for (const StudyRow& row : rows) {
    if (!row.usable() || !good(row)) continue;
    if (best == nullptr || row.wall_seconds < best->wall_seconds) best = &row;
  }
  return best;
}

}  // namespace

bool StudySetting::operator==(const StudySetting& other) const {
  return scheme == other.scheme && rate == other.rate && substeps == other.substeps &&
         newton_tolerance == other.newton_tolerance && accuracy == other.accuracy;
}

std::string describe(const StudySetting& setting) {
  std::ostringstream text;
  text << name(setting.scheme) << ", " << setting.rate << " Hz";
  if (setting.substeps > 1) text << ", " << setting.substeps << " sub-steps";
  if (setting.newton_tolerance) text << ", Newton to " << *setting.newton_tolerance;
  if (setting.accuracy) text << ", accuracy " << *setting.accuracy << " m";
  return text.str();
}

std::string studyHeader() { return kHeader; }

std::string toCsv(const StudyRow& row) {
  const StudySetting& s = row.setting;
  std::ostringstream line;
  line << name(s.scheme) << ',' << allDigits(s.rate) << ',' << s.substeps << ','
       << allDigits(s.newton_tolerance) << ',' << allDigits(row.rms_error) << ','
       << allDigits(row.max_error) << ',' << allDigits(row.energy_error) << ','
       << allDigits(row.wall_seconds) << ',' << allDigits(row.step_median) << ',' << row.status
       << ',' << allDigits(s.accuracy) << ',' << allDigits(row.momentum_error) << ','
       << allDigits(row.end_energy) << ',' << allDigits(row.end_height) << ',' << row.totals.steps
       << ',' << row.totals.substeps << ',' << row.totals.newton_iterations << ','
       << row.totals.linear_iterations << ',' << row.totals.factorizations << ','
       << row.totals.unconverged_steps << ',';
  if (row.mode_errors) line << allDigits(row.mode_errors->frequency);
  line << ',';
  if (row.mode_errors) line << allDigits(row.mode_errors->damping);
  return line.str();
}

std::vector<StudyRow> readStudyRows(std::istream& file) {
  std::string line;
  if (!std::getline(file, line) || line != kHeader) {
    throw std::runtime_error("it does not begin with the columns of a study");
  }
  std::vector<StudyRow> rows;
  for (int n = 2; std::getline(file, line); ++n) {
    if (file.eof()) break;  // no newline: it was not written to its end
    try {
      const std::vector<std::string> fields = split(line);
      if (fields.size() != kColumns) throw std::invalid_argument("columns");
      rows.push_back(parse(fields));
    } catch (const std::logic_error&) {  // invalid_argument, out_of_range
      throw std::runtime_error("line " + std::to_string(n) + " is no row of a study");
    }
  }
  return rows;
}

std::vector<StudyRow> frontier(const std::vector<StudyRow>& rows) {
  std::vector<StudyRow> sorted;
  for (const StudyRow& row : rows) {
    if (row.usable() && std::isfinite(row.rms_error)) sorted.push_back(row);
  }
  std::stable_sort(sorted.begin(), sorted.end(), [](const StudyRow& a, const StudyRow& b) {
    return a.wall_seconds < b.wall_seconds;
  });
  std::vector<StudyRow> best;
  for (const StudyRow& row : sorted) {
    if (best.empty() || row.rms_error < best.back().rms_error) best.push_back(row);
  }
  return best;
}

const StudyRow* cheapest(const std::vector<StudyRow>& rows, double error) {
  return cheapestOf(rows, [&](const StudyRow& row) { return row.rms_error <= error; });
}

const StudyRow* cheapestForModes(const std::vector<StudyRow>& rows, double error) {
  return cheapestOf(rows, [&](const StudyRow& row) {
    return row.mode_errors && row.mode_errors->frequency <= error &&
           row.mode_errors->damping <= error;
  });
}

}  // namespace mass_spring
