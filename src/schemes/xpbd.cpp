#include "schemes/xpbd.h"

#include <algorithm>

namespace mass_spring {

Xpbd::Xpbd(Workspace& workspace, const SolverOptions& options) : workspace_(workspace) {
  const Model& model = workspace.model();
  before_.setZero(3, model.particleCount());
  accelerations_.setZero(3, model.particleCount());
  mobilities_.setZero(3, model.particleCount());
  const auto* springs = find<Springs>(model);
  if (springs) springs_.emplace(springs->batches(), model.masses);
  const auto isOther = [springs](const Effect& effect) {
    return &effect != springs && !effect.traits().constant;
  };
  if (std::any_of(model.effects.begin(), model.effects.end(),
                  [&](const auto& effect) { return isOther(*effect); })) {
    others_.emplace(workspace, options, isOther);
  }
}

SubstepReport Xpbd::advance(double h, const Drive& drive, State& state) {
  before_ = state.positions;
  findMobilities(drive);
  advanceFreely(h, drive, state);
  if (springs_) {
    springs_->relax(h, drive.pinned, drive.effects.rest_lengths, before_, state.positions);
    const double *x = state.positions.data(), *from = before_.data(), *m = mobilities_.data();
    double* v = state.velocities.data();
    const double rate = 1.0 / h;
    for (Eigen::Index k = 0; k < before_.size(); ++k) {
      const double mean = rate * (x[k] - from[k]);
      v[k] = m[k] > 0.0 ? mean : v[k];
    }
  }
  if (!others_) return {};
  state.positions = before_;
  const Drive unloaded{drive.pinned, nullptr, drive.effects, drive.time};
  return others_->scheme.advance(Scheme::kLinearImplicitEuler, h, unloaded, state);
}

void Xpbd::findMobilities(const Drive& drive) {
  if (pinned_ == drive.pinned) return;
  pinned_ = drive.pinned;
  for (Eigen::Index i = 0; i < mobilities_.cols(); ++i) {
    mobilities_.col(i).setConstant(drive.isPinned(i) ? 0.0 : 1.0 / workspace_.model().masses[i]);
  }
  accelerations_.setZero();
  Sums sums;
  sums.forces = &accelerations_;
  const Point any = drive.point(before_, before_, 0.0);
  for (const Workspace::Part& part : workspace_.parts()) {
    if (part.effect->traits().constant) part.effect->add(any, part.scratch.get(), sums);
  }
  accelerations_.array() *= mobilities_.array();
}

void Xpbd::advanceFreely(double h, const Drive& drive, State& state) const {
  state.velocities += h * accelerations_;
  if (drive.loads) state.velocities += h * mobilities_.cwiseProduct(*drive.loads);
  state.positions += h * state.velocities;
}

}  // namespace mass_spring
