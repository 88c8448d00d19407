#include "effects/spring_relaxation.h"

#include "effects/spring_direction.h"

namespace mass_spring {

SpringRelaxation::SpringRelaxation(const SpringBatches& batches, const Eigen::VectorXd& masses)
    : batches_(batches), masses_(masses) {
  const auto particles = static_cast<std::size_t>(masses.size());
  inverse_masses_.reset(particles, 1);
  before_.reset(particles, 3);
  positions_.reset(particles, 3);
  for (std::size_t run = 0; run < batches.runs().size(); ++run) {
    const SpringBatch& batch = batches.runs()[run];
    const RelaxedLanes relaxed(batch);
    for (std::uint32_t pass = 0; pass < relaxed.passes; ++pass) {
      passes_.push_back({run, first_gathered_});
      first_gathered_ += batch.lanes;
    }
  }
  std::size_t gathered = 0;
  for (const SpringBatch& batch : batches.gathered()) gathered += batch.ends_i.size();
  shares_.resize(first_gathered_ + gathered);
}

double SpringRelaxation::share(double stiffness, double damping, std::uint32_t i,
                               std::uint32_t j) const {
  const double* w = inverse_masses_[0];
  return 1.0 / (1.0 + (stiffness * h_ + damping) * h_ * (w[i] + w[j]));
}

void SpringRelaxation::findShares(double h, const std::vector<char>& pinned) {
  if (h == h_ && pinned == pinned_) return;
  h_ = h;
  pinned_ = pinned;
  for (Eigen::Index i = 0; i < masses_.size(); ++i) {
    inverse_masses_[0][i] = pinned[static_cast<std::size_t>(i)] ? 0.0 : 1.0 / masses_[i];
  }
  std::uint32_t pass = 0;
  for (std::size_t p = 0; p < passes_.size(); ++p) {
    const SpringBatch& batch = batches_.runs()[passes_[p].run];
    const RelaxedLanes relaxed(batch);
    pass = p > 0 && passes_[p - 1].run == passes_[p].run ? pass + 1 : 0;
    auto gap = batch.gaps.begin();
    for (std::uint32_t s = 0; s < batch.lanes; ++s) {
      double& lane = shares_[passes_[p].first_share + s];
      lane = 0.0;
      if (gap != batch.gaps.end() && *gap == s) {
        ++gap;
      } else if (relaxed.inPass(pass, s)) {
        const std::size_t value = batch.uniform ? 0 : s;
        lane = share(batches_.stiffness(batch)[value],
                     batch.damped ? batches_.damping(batch)[value] : 0.0, batch.i + s, batch.j + s);
      }
    }
  }
  std::size_t next = first_gathered_;
  for (const SpringBatch& batch : batches_.gathered()) {
    for (std::size_t s = 0; s < batch.ends_i.size(); ++s) {
      shares_[next++] =
          share(batches_.stiffness(batch)[s], batch.damped ? batches_.damping(batch)[s] : 0.0,
                batch.ends_i[s], batch.ends_j[s]);
    }
  }
}

void SpringRelaxation::relax(double h, const std::vector<char>& pinned,
                             const std::vector<double>& current, const Vectors& before,
                             Vectors& positions) {
  SpringBatches::RestLengths rest_lengths;
  findShares(h, pinned);
  const auto particles = static_cast<std::uint32_t>(positions.cols());
  separate(before, 0, particles, before_);
  separate(positions, 0, particles, positions_);
  const Relaxation relaxation{h_, inverse_masses_[0], before_, positions_};
  for (const Pass& pass : passes_) {
    const SpringBatch& batch = batches_.runs()[pass.run];
    SpringLanes lanes;
    lanes.lanes = batch.lanes;
    lanes.uniform = batch.uniform;
    lanes.damped = batch.damped;
    lanes.stiffness = batches_.stiffness(batch);
    lanes.rest_length = batches_.restLength(batch, current, rest_lengths);
    lanes.damping = batch.damped ? batches_.damping(batch) : nullptr;
    relaxRun(batch, lanes, shares_.data() + pass.first_share, relaxation);
  }
  relaxGathered(current);
  positions.setZero();
  moveInto(positions, 0, particles, positions_);
}

void SpringRelaxation::relaxGathered(const std::vector<double>& current) {
  SpringBatches::RestLengths rest_lengths;
  const double* w = inverse_masses_[0];
  const auto at = [](const Columns& columns, std::uint32_t i) {
    return Eigen::Vector3d(columns[0][i], columns[1][i], columns[2][i]);
  };
  const auto move = [&](std::uint32_t i, const Eigen::Vector3d& by) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      positions_[axis][i] += by[static_cast<Eigen::Index>(axis)];
    }
  };
  std::size_t next = first_gathered_;
  for (const SpringBatch& batch : batches_.gathered()) {
    const double* stiffness = batches_.stiffness(batch);
    const double* rest_length = batches_.restLength(batch, current, rest_lengths);
    const double* damping = batch.damped ? batches_.damping(batch) : nullptr;
    for (std::size_t s = 0; s < batch.ends_i.size(); ++s) {
      const std::uint32_t i = batch.ends_i[s], j = batch.ends_j[s];
      const Eigen::Vector3d d = at(positions_, j) - at(positions_, i);
      const SpringDirection direction(d);
      double f = h_ * stiffness[s] * (direction.length - rest_length[s]);
      if (damping) f += damping[s] * direction.n.dot(d - (at(before_, j) - at(before_, i)));
      const Eigen::Vector3d moved = (h_ * f * shares_[next++]) * direction.n;
      move(i, w[i] * moved);
      move(j, -w[j] * moved);
    }
  }
}

}  // namespace mass_spring
