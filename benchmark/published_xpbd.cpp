#include "published_xpbd.h"

#include <algorithm>
#include <cmath>

namespace mass_spring {
namespace {

/// Greedily, each spring gets the first color that neither of its particles has; the springs of
/// one color in their order, then those of the next.
std::vector<Spring> byColor(const std::vector<Spring>& springs, std::uint32_t particles) {
  std::vector<std::vector<char>> used(particles);
  std::vector<std::vector<Spring>> colors;
  for (const Spring& spring : springs) {
    std::size_t color = 0;
    const auto taken = [&](std::uint32_t p) {
      return color < used[p].size() && used[p][color] != 0;
    };
    while (taken(spring.i) || taken(spring.j)) ++color;
    for (const std::uint32_t p : {spring.i, spring.j}) {
      if (used[p].size() <= color) used[p].resize(color + 1, 0);
      used[p][color] = 1;
    }
    if (colors.size() <= color) colors.resize(color + 1);
    colors[color].push_back(spring);
  }
  std::vector<Spring> sorted;
  for (const std::vector<Spring>& color : colors) {
    sorted.insert(sorted.end(), color.begin(), color.end());
  }
  return sorted;
}

}  // namespace

PublishedXpbd::PublishedXpbd(const RivalScene& scene, int substeps, int iterations, Order order)
    : h_(scene.step / substeps),
      substeps_(substeps),
      iterations_(iterations),
      gravity_(scene.gravity) {
  const Model& model = scene.model;
  for (std::uint32_t i = 0; i < model.particleCount(); ++i) {
    particles_.push_back(
        {model.start.positions.col(i), scene.pinned[i] ? 0.0 : 1.0 / model.masses[i]});
    velocities_.push_back(model.start.velocities.col(i));
    before_.push_back(particles_.back().x);
  }
  for (const Spring& spring :
       order == Order::kByColor ? byColor(model.springs, model.particleCount()) : model.springs) {
    const double weight = particles_[spring.i].inverse_mass + particles_[spring.j].inverse_mass;
    if (spring.stiffness == 0.0 || weight == 0.0) continue;
    Constraint c;
    c.i = spring.i;
    c.j = spring.j;
    c.rest_length = spring.rest_length;
    c.compliance = 1.0 / (spring.stiffness * h_ * h_);
    // gamma = (alpha / h^2) (h^2 beta) / h
    c.damping = spring.damping / (spring.stiffness * h_);
    c.denominator = 1.0 / ((1.0 + c.damping) * weight + c.compliance);
    constraints_.push_back(c);
  }
  multipliers_.resize(constraints_.size());
}

/// The only iteration of a sub-step: the multipliers are zero before it.
void PublishedXpbd::projectOnce() {
  for (const Constraint& c : constraints_) {
    Particle &a = particles_[c.i], &b = particles_[c.j];
    const Eigen::Vector3d d = b.x - a.x;
    const double length = d.norm();
    const Eigen::Vector3d n = d / length;
    const double moved = n.dot(d - (before_[c.j] - before_[c.i]));
    const double change = -(length - c.rest_length + c.damping * moved) * c.denominator;
    a.x -= (a.inverse_mass * change) * n;
    b.x += (b.inverse_mass * change) * n;
  }
}

void PublishedXpbd::project() {
  std::fill(multipliers_.begin(), multipliers_.end(), 0.0);
  for (int iteration = 0; iteration < iterations_; ++iteration) {
    for (std::size_t k = 0; k < constraints_.size(); ++k) {
      const Constraint& c = constraints_[k];
      Particle &a = particles_[c.i], &b = particles_[c.j];
      const Eigen::Vector3d d = b.x - a.x;
      const double length = d.norm();
      const Eigen::Vector3d n = d / length;
      const double moved = n.dot(d - (before_[c.j] - before_[c.i]));
      const double change =
          -(length - c.rest_length + c.compliance * multipliers_[k] + c.damping * moved) *
          c.denominator;
      multipliers_[k] += change;
      a.x -= (a.inverse_mass * change) * n;
      b.x += (b.inverse_mass * change) * n;
    }
  }
}

void PublishedXpbd::step() {
  for (int substep = 0; substep < substeps_; ++substep) {
    for (std::size_t i = 0; i < particles_.size(); ++i) {
      before_[i] = particles_[i].x;
      if (particles_[i].inverse_mass == 0.0) continue;
      particles_[i].x += h_ * (velocities_[i] + h_ * gravity_);
    }
    if (iterations_ == 1) {
      projectOnce();
    } else {
      project();
    }
    for (std::size_t i = 0; i < particles_.size(); ++i) {
      velocities_[i] = (particles_[i].x - before_[i]) / h_;
    }
  }
}

Vectors PublishedXpbd::positions() const {
  Vectors positions(3, static_cast<Eigen::Index>(particles_.size()));
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    positions.col(static_cast<Eigen::Index>(i)) = particles_[i].x;
  }
  return positions;
}

std::vector<RivalSeries> xpbdSeries() {
  const auto setting = [](int substeps, int iterations, PublishedXpbd::Order order) {
    return RivalSetting{std::to_string(substeps) + " x " + std::to_string(iterations),
                        [=](const RivalScene& scene) -> std::unique_ptr<Rival> {
                          return std::make_unique<PublishedXpbd>(scene, substeps, iterations,
                                                                 order);
                        }};
  };
  RivalSeries springs{"XPBD (springs in order)", {}}, colors{"XPBD (by color)", {}};
  for (const int n : {1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000, 20000, 50000}) {
    springs.settings.push_back(setting(n, 1, PublishedXpbd::Order::kOfSprings));
    colors.settings.push_back(setting(n, 1, PublishedXpbd::Order::kByColor));
  }
  RivalSeries iterations{"XPBD 2016 (iterations)", {}};
  for (const int n : {10, 50, 200, 1000}) {
    iterations.settings.push_back(setting(1, n, PublishedXpbd::Order::kByColor));
  }
  return {springs, colors, iterations};
}

}  // namespace mass_spring
