#include "linear_step.h"

#include "plain_eigen.h"

namespace mass_spring {
namespace {

constexpr double kTolerance = 1e-6;  // |b - A v| / |b| of the conjugate gradients
constexpr int kDoublings = 15;

class LinearStep : public Rival {
 public:
  LinearStep(const RivalScene& scene, int substeps, PlainEigen::Solver solver)
      : substeps_(substeps),
        state_(scene.model.start),
        eigen_(scene.model, scene.gravity, scene.pinned, scene.step / substeps, solver,
               kTolerance) {}

  void step() override {
    for (int substep = 0; substep < substeps_; ++substep) {
      eigen_.assemble(state_);
      eigen_.solve(state_);
    }
  }
  Vectors positions() const override { return state_.positions; }

 private:
  int substeps_;
  State state_;
  PlainEigen eigen_;
};

}  // namespace

std::vector<RivalSeries> linearStepSeries() {
  const auto series = [](const char* name, PlainEigen::Solver solver) {
    RivalSeries one{name, {}};
    for (int k = 0; k < kDoublings; ++k) {
      one.settings.push_back({std::to_string(1 << k) + " sub-steps",
                              [=](const RivalScene& scene) -> std::unique_ptr<Rival> {
                                return std::make_unique<LinearStep>(scene, 1 << k, solver);
                              }});
    }
    return one;
  };
  return {series("Eigen CG", PlainEigen::Solver::kConjugateGradient),
          series("Eigen SimplicialLDLT", PlainEigen::Solver::kSimplicialLdlt),
          series("CHOLMOD", PlainEigen::Solver::kCholmod)};
}

}  // namespace mass_spring
