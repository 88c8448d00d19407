#include "recorded_timeline.h"

#include <cmath>
#include <utility>

#include "bag_topic.h"
#include "mass_spring_sim/scene_reader.h"

namespace mass_spring {

namespace {

/// When a command is due that is to act on a step first (see Simulation::timelineDue). The
/// quotient alone would be due one step late where its rounding is above 1e-9 of a step.
double timeBefore(std::uint64_t step, double rate) {
  const auto steps_done = static_cast<double>(step - 1);
  double time = steps_done / rate;
  while (time * rate > steps_done) time = std::nextafter(time, 0.0);
  return time;
}

/// A timeline names its objects where there are several; a command need not where there is one.
void nameObject(const Scene& scene, std::string& object) {
  if (object.empty()) object = scene.objects.front().name;
}

}  // namespace

void RecordedTimeline::startOver(const Scene& scene) {
  scene_ = scene;
  scene_.timeline.clear();
  obstacle_.clear();
}

void RecordedTimeline::add(std::uint64_t step, Command command) {
  if (auto* force = std::get_if<ForceCommand>(&command)) nameObject(scene_, force->object);
  if (auto* pin = std::get_if<PinCommand>(&command)) nameObject(scene_, pin->object);
  scene_.timeline.push_back({timeBefore(step, scene_.rate), std::move(command)});
}

void RecordedTimeline::refuse(const std::string& what) {
  if (obstacle_.empty()) obstacle_ = what;
}

std::string RecordedTimeline::toYaml() const {
  if (!obstacle_.empty()) throw BagError("a timeline cannot say " + obstacle_);
  const std::string yaml = mass_spring::toYaml(scene_);
  try {
    if (mass_spring::toYaml(readScene(readYamlText(yaml, "the timeline"), "")) == yaml) return yaml;
  } catch (const SceneError& error) {
    throw BagError(std::string("no scene can say it: ") + error.what());
  }
  throw BagError("no scene can say it: some numbers would not be the same");
}

}  // namespace mass_spring
