#include "schemes/xpbd.h"

#include <utility>

namespace mass_spring {

Xpbd::Xpbd(const Model& model, const SolverOptions& options) : model_(model) {
  before_.setZero(3, model.particleCount());
  accelerations_.setZero(3, model.particleCount());
  mobilities_.setZero(3, model.particleCount());
  if (model.springs_effect) springs_.emplace(model.springs_effect->batches(), model.masses);
  std::vector<const Effect*> others;
  for (const auto& effect : model.effects) {
    if (effect.get() != model.springs_effect && !effect->constant()) others.push_back(effect.get());
  }
  if (!others.empty()) others_.emplace(model, options, std::move(others));
}

SubstepReport Xpbd::advance(double h, const Drive& drive, State& state) {
  before_ = state.positions;
  findMobilities(drive);
  advanceFreely(h, drive, state);
  if (springs_) {
    springs_->relax(h, drive.pinned, before_, state.positions);
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
  const Drive unloaded{drive.pinned, nullptr, drive.time};
  return others_->scheme.advance(Scheme::kLinearImplicitEuler, h, unloaded, state);
}

void Xpbd::findMobilities(const Drive& drive) {
  if (pinned_ == drive.pinned) return;
  pinned_ = drive.pinned;
  for (Eigen::Index i = 0; i < mobilities_.cols(); ++i) {
    mobilities_.col(i).setConstant(drive.isPinned(i) ? 0.0 : 1.0 / model_.masses[i]);
  }
  accelerations_.setZero();
  for (const auto& effect : model_.effects) {
    if (effect->constant()) {
      effect->addForces(before_, before_, accelerations_);  // of any positions and velocities
    }
  }
  accelerations_.array() *= mobilities_.array();
}

void Xpbd::advanceFreely(double h, const Drive& drive, State& state) const {
  state.velocities += h * accelerations_;
  if (drive.loads) state.velocities += h * mobilities_.cwiseProduct(*drive.loads);
  state.positions += h * state.velocities;
}

}  // namespace mass_spring
