// The same scenes by this package and by what one would take instead: which error at what time.
//
//   rivals [--help]

#include <cmath>
#include <cstdio>
#include <fstream>

#include "bullet_bodies.h"
#include "linear_step.h"
#include "published_xpbd.h"
#include "rival_run.h"
#include "scenes.h"
#include "scheme_choice.h"
#include "tools/command_line.h"
#include "tools/study_report.h"
#include "tools/study_sweep.h"

namespace mass_spring {
namespace {

// rk4, per spring and step: four forces. For predictions alone.
constexpr double kSecondsPerSpring = 1e-8;
constexpr double kReferenceShare = 0.6;  // of the stable step, as references begin
constexpr int kFewestFrames = 3;

constexpr const char* kOmissions =
    "Left out, or not the same physics:\n\n"
    "| what | why |\n|---|---|\n"
    "| Bullet, position based | run, but its stiffness is a share in [0, 1], here 1, and no N/m, "
    "and "
    "it has no damping along springs: sheets err by what it lacks at any setting |\n"
    "| Bullet, double precision | not run: one program cannot link both; its conjugate gradients "
    "then go on to 2e-16 in every step |\n"
    "| Bullet's own btDeformableMassSpringForce | run with each link's own stiffness in its place: "
    "it knows but one, and one for bending |\n"
    "| XPBD on graphics processors, in single precision | not run: this is about one core |\n"
    "| PositionBasedDynamics, VegaFEM, FastMassSpring, fabric_simulator | not run: not packaged; "
    "XPBD and Eigen stand for their methods |\n"
    "| MuJoCo | not run: no springs between particles but by tendons, one by one |\n";

struct Options {
  std::vector<int> sizes = {20, 50, 100};
  std::vector<double> stiffness = {1.0, 1e3, 1e6};
  double duration = 0.5;           // s
  double reference_limit = 300.0;  // s
  std::string output;
  int threads = 1;
  bool others = true;  // rope and lattice
  RivalRunOptions run;
};

Options readOptions(int argc, char** argv) {
  CommandLine line("rivals", "Runs the same scenes in this package and its rivals.", "");
  line.addRequired("output", "TEXT", "CSV file");
  line.addList("sizes", "INT", "N of the cloth, by commas (default 20,50,100)");
  line.addList("stiffness", "FLOAT", "factors, by commas (default 1,1e3,1e6)");
  line.addOption("duration", "FLOAT", "simulated seconds (default 0.5)");
  line.addOption("time-limit", "FLOAT",
                 "seconds for each rival, and each of our schemes, on each scene (default 10)");
  line.addOption("reference-limit", "FLOAT",
                 "seconds for each reference: scenes are cut to what that allows (default 300)");
  line.addOption("threads", "UINT", "of ours; the rivals have one (default 1)");
  line.addFlag("cloth-only", "no rope, no lattice");
  line.addFlag("quick", "a small cloth, briefly: to see that everything works");
  line.parse(argc, argv);

  Options options;
  options.output = line.value("output");
  const std::vector<double> sizes = line.numbers("sizes", 2, 1000, "a number from 2 to 1000");
  if (!sizes.empty()) options.sizes.assign(sizes.begin(), sizes.end());
  const std::vector<double> stiffness =
      line.numbers("stiffness", 1e-6, 1e9, "a factor from 1e-6 to 1e9");
  if (!stiffness.empty()) options.stiffness = stiffness;
  const auto seconds = [&line](const std::string& name, double least, double most, double& value) {
    const std::string range = std::to_string(least) + " to " + std::to_string(most);
    for (const double number : line.numbers(name, least, most, "seconds from " + range)) {
      value = number;
    }
  };
  seconds("duration", 0.1, 100.0, options.duration);
  seconds("time-limit", 0.01, 1e5, options.run.time_limit);
  seconds("reference-limit", 0.01, 1e5, options.reference_limit);
  options.threads = static_cast<int>(line.integer("threads", 1, 256, 1));
  options.others = !line.has("cloth-only");
  if (line.has("quick")) {
    options.sizes = {8};
    options.stiffness = {1.0};
    options.duration = 0.2;
    options.run.time_limit = 0.2;
  }
  return options;
}

struct NamedScene {
  std::string name;
  Scene scene;
};

Scene stiffened(Scene scene, double factor) {
  auto& cloth = std::get<Cloth>(scene.objects.at(0).shape);
  cloth.stiffness *= factor;
  if (cloth.shear_stiffness) *cloth.shear_stiffness *= factor;
  if (cloth.bend_stiffness) *cloth.bend_stiffness *= factor;
  return scene;
}

std::vector<NamedScene> makeScenes(const Options& options) {
  std::vector<NamedScene> scenes;
  for (const int n : options.sizes) {
    for (const double factor : options.stiffness) {
      char name[60];
      std::snprintf(name, sizeof name, "cloth %d x%g", n, factor);
      scenes.push_back({name, stiffened(hangingCloth(n), factor)});
    }
  }
  if (options.others) {
    scenes.push_back({"rope 200", swingingRope(200)});
    scenes.push_back({"lattice 8", hangingLattice(8)});
  }
  for (NamedScene& one : scenes) one.scene.solver.threads = options.threads;
  return scenes;
}

/// As long as the reference is affordable [s], in whole frames: it is run four times at least.
double affordableDuration(const Scene& scene, double frame_rate, const Options& options) {
  const Model model = buildModel(scene);
  const double h = kReferenceShare * stableRk4Step(boundSpectrum(model));
  const double steps_per_frame = std::max(1.0 / (frame_rate * h), 2000.0 / frame_rate);
  const double frame =
      4.0 * steps_per_frame * static_cast<double>(model.springs.size()) * kSecondsPerSpring;
  const double frames =
      std::min(std::floor(options.reference_limit / frame), options.duration * frame_rate);
  return frames / frame_rate;
}

int run(const Options& options) {
  std::ofstream csv(options.output);
  csv << rivalHeader() << '\n' << std::flush;
  std::vector<RivalSeries> rivals;
  for (const auto& some : {xpbdSeries(), linearStepSeries(), bulletSeries()}) {
    rivals.insert(rivals.end(), some.begin(), some.end());
  }
  std::string tables, omissions = kOmissions;
  for (const NamedScene& one : makeScenes(options)) {
    Study study;
    study.scene = one.scene;
    study.frame_rate = frameRate(study.scene, {});
    study.duration = affordableDuration(study.scene, study.frame_rate, options);
    if (study.duration * study.frame_rate < kFewestFrames) {
      omissions += "| " + one.name + " | no reference in --reference-limit |\n";
      continue;
    }
    ReferenceOptions reference;
    reference.duration = study.duration;
    reference.frame_rate = study.frame_rate;
    reference.seconds = options.reference_limit;
    study.reference = findReference(study.scene, reference);
    study.compared = framesToCompare(study.reference);
    const std::vector<RivalRow> rows = measureAll(study, one.name, rivals, options.run);
    for (const RivalRow& row : rows) csv << toCsv(row) << '\n';
    csv << std::flush;
    if (!csv) {
      std::fprintf(stderr, "rivals: %s could not be written\n", options.output.c_str());
      return 2;
    }
    char about[200];
    std::snprintf(about, sizeof about,
                  "\n%s: %.2f s simulated, errors up to %.2f s; reference known to %.1e mm\n\n",
                  one.name.c_str(), study.duration,
                  static_cast<double>(study.compared) / study.frame_rate, 1e3 * finestShown(study));
    tables += about + rivalTable(rows, finestShown(study));
  }
  std::printf("%s\n%s", tables.c_str(), omissions.c_str());
  return 0;
}

}  // namespace
}  // namespace mass_spring

int main(int argc, char** argv) {
  using namespace mass_spring;
  try {
    return run(readOptions(argc, argv));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "rivals: %s\n", error.what());
    return 2;
  }
}
