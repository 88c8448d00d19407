#include "hanging_cloth.h"

#include "mass_spring_sim/scene_reader.h"

namespace mass_spring {

Scene hangingCloth(int n) {
  Scene scene = readSceneFile(MASS_SPRING_BENCHMARK_DIR "/hanging_cloth.yaml");
  std::get<Cloth>(scene.objects.at(0).shape).resolution = {n, n};
  for (ScenePin& pin : scene.pins) {
    if (pin.name == "right") pin.particles = {static_cast<std::uint32_t>(n - 1)};
  }
  return scene;
}

}  // namespace mass_spring
