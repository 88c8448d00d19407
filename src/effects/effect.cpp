#include "effects/effect.h"

#include "thread_pool.h"

namespace mass_spring {

Workspace::Workspace(const Model& model, std::shared_ptr<ThreadPool> threads)
    : model_(model),
      threads_(threads ? std::move(threads) : std::make_shared<ThreadPool>(model.threads)) {
  for (const auto& effect : model.effects) {
    parts_.push_back({effect.get(), dynamic_cast<const DrivingEffect*>(effect.get()),
                      dynamic_cast<const SweptEffect*>(effect.get()),
                      dynamic_cast<const ForeseeingEffect*>(effect.get()),
                      effect->makeScratch(*threads_)});
  }
}

Workspace::~Workspace() = default;

void sumForces(Workspace& workspace, const Vectors* loads, const Point& point, Vectors& forces) {
  Sums sums;
  sums.forces = &forces;
  sumForces(workspace, loads, point, sums);
}

void sumForces(Workspace& workspace, const Vectors* loads, const Point& point, const Sums& sums) {
  sums.forces->setZero();
  for (const Workspace::Part& part : workspace.parts()) {
    part.effect->add(point, part.scratch.get(), sums);
  }
  if (loads) *sums.forces += *loads;
}

void addEnergy(Workspace& workspace, const Point& point, const Effect* without, Energy& energy) {
  Sums sums;
  sums.energy = &energy;
  for (const Workspace::Part& part : workspace.parts()) {
    if (part.effect != without) part.effect->add(point, part.scratch.get(), sums);
  }
}

void addForceDerivative(Workspace& workspace, const Point& point, const Vectors& dx,
                        const Vectors& dv, Vectors& df) {
  for (const Workspace::Part& part : workspace.parts()) {
    part.effect->addForceDerivative(point, part.scratch.get(), dx, dv, df);
  }
}

bool dependsOnTime(Workspace& workspace, const Point& point) {
  for (const Workspace::Part& part : workspace.parts()) {
    if (part.driving && part.driving->dependsOnTime(point)) return true;
  }
  return false;
}

void beginSubstep(Workspace& workspace, const Vectors& positions, const Vectors& velocities,
                  double h) {
  for (const Workspace::Part& part : workspace.parts()) {
    if (part.swept) part.swept->beginSubstep(*part.scratch, positions, velocities, h);
  }
}

bool endSubstep(Workspace& workspace, const Vectors& positions) {
  bool passed = false;
  for (const Workspace::Part& part : workspace.parts()) {
    if (part.swept) passed = part.swept->endSubstep(*part.scratch, positions) || passed;
  }
  return passed;
}

}  // namespace mass_spring
