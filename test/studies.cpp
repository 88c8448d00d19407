#include "studies.h"

#include "mass_spring_sim/scene_reader.h"

namespace mass_spring {

const char* const kPendulum = R"(
rate: 240.0
solver: {scheme: tr_bdf2, threads: 1}
objects:
  bob:
    type: particles
    positions: [[0.0, 0.0, 1.0], [0.2, 0.0, 1.0]]
    masses: 0.1
    springs: [[0, 1]]
    stiffness: 50.0
    damping: 0.01
pins:
  nail: {object: bob, particles: [0]}
effects:
  gravity: {acceleration: [0.0, 0.0, -9.81]}
)";

const char* const kBouncing = R"(
rate: 60.0
solver: {scheme: tr_bdf2, newton_tolerance: 1.0e-12, threads: 1}
objects:
  bob:
    type: particles
    positions: [[0.0, 0.0, 1.0], [0.0, 0.0, 0.45]]
    masses: 0.1
    springs: [[0, 1]]
    stiffness: 50.0
    damping: 0.3
    rest_lengths: 0.52
pins: {nail: {object: bob, particles: [0]}}
effects: {gravity: {acceleration: [0.0, 0.0, -9.81]}}
)";

Study studyOf(const Scene& scene, double duration) {
  Study study;
  study.scene = scene;
  study.duration = duration;
  study.frame_rate = study.scene.rate;
  ReferenceOptions options;
  options.duration = duration;
  options.frame_rate = study.frame_rate;
  study.reference = findReference(study.scene, options);
  study.compared = study.reference.frames.size();
  study.modes = findModes(study.scene, study.reference, study.frame_rate, study.compared);
  return study;
}
Study studyOf(const std::string& scene, double duration) {
  return studyOf(readScene(readYamlText(scene, "scene"), ""), duration);
}

}  // namespace mass_spring
