// Steps a plain scene, after another one in the same process that has the effects named on the
// command line: for callgrind, which counts what countedSteps() executes.
#include <cstring>
#include <iostream>

#include "mass_spring_sim/scene_reader.h"
#include "mass_spring_sim/simulation.h"

namespace {

using namespace mass_spring;

Scene scene(const std::string& scheme, const std::string& effects) {
  return readScene(readYamlText(R"(
rate: 100.0
solver: {threads: 1, scheme: )" + scheme +
                                    R"(}
objects:
  sheet: {type: cloth, size: [1.0, 1.0], resolution: [10, 10], position: [0, 0, 1], mass: 0.2,
          stiffness: 100.0, shear_stiffness: 10.0, damping: 0.01}
pins: {corner: {object: sheet, particles: [0]}}
effects: {gravity: {acceleration: [0.0, 0.0, -9.81]})" +
                                    effects + "}\n",
                                "counted scene"),
                   "");
}

}  // namespace

/// Not inlined, and with a name that callgrind is told.
extern "C" __attribute__((noinline)) void countedSteps(Simulation& simulation) {
  for (int n = 0; n < 5; ++n) simulation.step();
}

int main(int argc, char** argv) {
  std::string effects;
  for (int i = 2; i < argc; ++i) effects += std::string(", ") + argv[i];
  const std::string scheme = argc > 1 ? argv[1] : "tr_bdf2";
  Simulation plain(scene(scheme, ""));
  if (!effects.empty()) {
    Simulation other(scene(scheme, effects));
    for (int n = 0; n < 3; ++n) other.step();
    std::cout << other.matrixNonzeros() << " nonzeros, plain ";
  }
  for (int n = 0; n < 3; ++n) plain.step();
  countedSteps(plain);
  std::cout << plain.matrixNonzeros() << " nonzeros\n";
}
