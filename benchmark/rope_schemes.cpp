// One step of a rope of 10,000 links by each implicit scheme, with its defaults; the first second.
//
//   rope_schemes [FRAMES]

#include <cstdio>
#include <cstdlib>

#include "contender.h"
#include "mass_spring_sim/simulation.h"
#include "scenes.h"

namespace mass_spring {
namespace {

void run(int frames) {
  std::puts(
      "| rope of 10,000 links, scheme | ms, median | ms, p90 | iterations of Newton | "
      "factorizations | not converged |\n|---|---|---|---|---|---|");
  for (const SchemeInfo& scheme : schemes()) {
    if (!scheme.implicit) continue;
    Scene rope = swingingRope(10000);
    rope.solver.scheme = scheme.scheme;
    rope.solver.threads = 1;
    Simulation simulation(std::move(rope));
    Contender contender;
    contender.step = [&simulation](State&) {
      return StepOutcome{simulation.step().linear_iterations, true};
    };
    bool comparable = true;
    for (int frame = 0; frame < frames; ++frame) {
      clockStep(contender, simulation.state(), frame, comparable);
    }
    std::vector<double> wall;
    for (const Contender::Sample& sample : contender.samples) wall.push_back(sample.wall);
    const StepTotals& totals = simulation.totals();
    std::printf("| %s | %.3g | %.3g | %.1f | %.1f | %d of %d |\n", scheme.name.c_str(),
                quantile(wall, 0.5), quantile(wall, 0.9),
                static_cast<double>(totals.newton_iterations) / frames,
                static_cast<double>(totals.factorizations) / frames,
                static_cast<int>(totals.unconverged_steps), frames);
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace mass_spring

int main(int argc, char** argv) {
  const int frames = argc > 1 ? std::atoi(argv[1]) : 60;
  if (frames < 1) {
    std::fputs("usage: rope_schemes [FRAMES]\n", stderr);
    return 1;
  }
  mass_spring::run(frames);
  return 0;
}
