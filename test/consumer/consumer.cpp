#include <algorithm>
#include <cmath>
#include <cstdio>

#include "mass_spring_sim/scene_reader.h"
#include "mass_spring_sim/simulation.h"

// A falling particle: symplectic Euler adds g h to the velocity, then v h to the position, so that
// after n steps v = n g h and z = g h^2 n (n + 1) / 2. Nothing here but rounding can differ.
int main() {
  const char* text = R"(
rate: 100.0
solver: {scheme: symplectic_euler}
objects:
  ball: {type: particles, positions: [[0.0, 0.0, 0.0]], masses: 0.5, springs: [], stiffness: 1.0}
effects:
  gravity: {acceleration: [0.0, 0.0, -9.81]}
)";
  using namespace mass_spring;
  Simulation simulation(readScene(readYamlText(text, "falling ball"), ""));
  constexpr int kSteps = 50;
  for (int i = 0; i < kSteps; ++i) {
    if (simulation.step().status != StepStatus::kConverged) return 1;
  }
  const double h = simulation.stepSize();
  const double velocity = -9.81 * h * kSteps;
  const double height = -9.81 * h * h * kSteps * (kSteps + 1) / 2;
  const State& state = simulation.state();
  const double error = std::max(std::abs(state.velocities(2, 0) - velocity),
                                std::abs(state.positions(2, 0) - height));
  std::printf("after %g s: z = %g m, vz = %g m/s, off by %g\n", state.time, state.positions(2, 0),
              state.velocities(2, 0), error);
  // Values of order 1, rounded kSteps times.
  return error < 1e-13 ? 0 : 1;
}
