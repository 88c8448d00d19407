#include "tools/study_end.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "mass_spring_sim/measures.h"

namespace mass_spring {

double Statistics::deviations(double value) const {
  return value == mean ? 0.0 : (value - mean) / deviation;
}

Statistics statistics(const std::vector<double>& values) {
  Statistics result;
  const auto n = static_cast<double>(values.size());
  for (const double value : values) result.mean += value / n;
  if (values.size() < 2) return result;
  double square = 0.0;
  for (const double value : values) square += std::pow(value - result.mean, 2);
  result.deviation = std::sqrt(square / (n - 1.0));
  return result;
}

double usualDeviations(std::size_t runs) {
  // Student's t at 0.975 for n - 1 degrees of freedom, times sqrt(1 + 1 / n).
  constexpr double kUsual[kStarts + 1] = {INFINITY, INFINITY, 15.56, 4.97, 3.56};
  return kUsual[runs];
}

std::string endText(const Study& study, const std::vector<StudyRow>& rows) {
  const Model model = buildModel(study.scene);
  const std::vector<State>& ends = study.reference.ends;
  std::vector<double> energies, heights;
  for (const State& end : ends) {
    energies.push_back(energy(model, end).total());
    heights.push_back(meanHeight(study.scene, end));
  }
  const State& last = study.reference.frames.back();
  const double end_energy = energy(model, last).total();
  const double end_height = meanHeight(study.scene, last);
  std::ostringstream out;
  out.precision(3);
  out << "At the end, " << study.duration << " s: total energy " << end_energy << " J, mean height "
      << end_height << " m; ";
  if (ends.size() < 2) {
    out << "from the start 1e-9 m apart they differ by " << std::abs(energies[0] - end_energy)
        << " J and " << std::abs(heights[0] - end_height)
        << " m. The columns end_energy_j and end_height_m of results.csv say what each setting "
           "makes of them.\n";
    return out.str();
  }
  const Statistics e = statistics(energies), h = statistics(heights);
  const double usual = usualDeviations(ends.size());
  out << "from " << ends.size() << " starts 1e-9 m apart " << e.mean << " J and " << h.mean
      << " m in the mean, with standard deviations of " << e.deviation << " J and " << h.deviation
      << " m. One more start would fall within " << usual
      << " deviations of the mean 19 times in 20. What the settings are off by:\n\n"
      << "| setting | energy | as one more start | mean height | as one more start |\n"
      << "|---|---|---|---|---|\n";
  const auto within = [&](const Statistics& of, double value) {
    return std::abs(of.deviations(value)) <= usual ? "yes" : "no";
  };
  for (const StudyRow& row : rows) {
    if (!row.usable()) continue;
    out << "| " << describe(row.setting) << " | " << row.end_energy - e.mean << " J | "
        << within(e, row.end_energy) << " | " << row.end_height - h.mean << " m | "
        << within(h, row.end_height) << " |\n";
  }
  return out.str();
}

}  // namespace mass_spring
