#include "scenes.h"

#include "mass_spring_sim/scene_reader.h"

namespace mass_spring {
namespace {

Scene read(const char* file) {
  return readSceneFile(std::string(MASS_SPRING_BENCHMARK_DIR "/") + file);
}

}  // namespace

Scene hangingCloth(int n) {
  Scene scene = read("hanging_cloth.yaml");
  std::get<Cloth>(scene.objects.at(0).shape).resolution = {n, n};
  for (ScenePin& pin : scene.pins) {
    if (pin.name == "right") pin.particles = {static_cast<std::uint32_t>(n - 1)};
  }
  return scene;
}

Scene hangingLattice(int n) {
  Scene scene = read("hanging_lattice.yaml");
  std::get<Lattice>(scene.objects.at(0).shape).resolution = {n, n, n};
  const auto side = static_cast<std::uint32_t>(n), top = (side - 1) * side * side;
  scene.pins.at(0).particles = {top, top + side - 1, top + side * (side - 1),
                                top + side * side - 1};
  return scene;
}

Scene swingingRope(int links) {
  Scene scene = read("swinging_rope.yaml");
  std::get<Rope>(scene.objects.at(0).shape).segments = links;
  return scene;
}

}  // namespace mass_spring
