#include "solvers/rest_shape.h"

#include <algorithm>
#include <tuple>

namespace mass_spring {
namespace {

/// A coarse particle of one axis, as seen by a fine one.
struct AxisEntry {
  std::uint32_t coarse;
  double weight;
};

/// Keeps every other particle of an axis and the last one; of two, the first.
/// @return per particle its entries of the linear interpolation between those that are kept
std::vector<std::vector<AxisEntry>> coarsenAxis(std::vector<double>& axis) {
  const auto n = static_cast<std::uint32_t>(axis.size());
  if (n == 2) {
    axis.pop_back();
    return {{{0, 1.0}}, {{0, 1.0}}};
  }
  std::vector<std::vector<AxisEntry>> entries(n);
  std::vector<double> coarse;
  for (std::uint32_t i = 0; i < n; ++i) {
    const auto before = static_cast<std::uint32_t>(coarse.size());
    if (i % 2 == 0 || i + 1 == n) {
      coarse.push_back(axis[i]);
      entries[i] = {{before, 1.0}};
    } else {
      const double share = (axis[i] - axis[i - 1]) / (axis[i + 1] - axis[i - 1]);
      entries[i] = {{before - 1, 1.0 - share}, {before, share}};
    }
  }
  axis = std::move(coarse);
  return entries;
}

/// Are the positions those of a net that is spread out, so that neighbors are near each other? Of
/// a scrambled start they are not: there the distance of neighbors is 1.4 times the mean distance
/// from the center, and 0.5 times for a lattice of no more than 6 x 6 x 6.
bool isSpreadOut(const Vectors& positions, const std::vector<Net::Pair>& pairs) {
  const Eigen::Vector3d center = positions.rowwise().mean();
  const double size = (positions.colwise() - center).colwise().norm().mean();
  double neighbors = 0.0;
  for (const Net::Pair& pair : pairs) {
    neighbors += (positions.col(pair.j) - positions.col(pair.i)).norm();
  }
  return neighbors < 0.8 * size * static_cast<double>(pairs.size());
}

}  // namespace

RestShape::RestShape(const Model& model) {
  for (const ModelObject& object : model.objects) {
    Body body;
    const auto springs = model.springs.begin() + object.first_spring;
    body.coupled = std::any_of(springs, springs + object.spring_count, [](const Spring& spring) {
      return spring.stiffness > 0.0 || spring.damping > 0.0;
    });
    if (object.resolution[0] > 0) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::uint32_t i = 0; i < object.resolution[axis]; ++i) body.axes[axis].push_back(i);
      }
    } else {
      body.net = netOf(model, object);
    }
    bodies_.push_back(std::move(body));
  }
}

Net RestShape::netOf(const Model& model, const ModelObject& object) {
  Net net;
  net.size = object.particle_count;
  const Vectors positions = model.start.positions.middleCols(object.first_particle, net.size);
  for (std::uint32_t s = 0; s < object.spring_count; ++s) {
    const Spring& spring = model.springs[object.first_spring + s];
    if (spring.stiffness == 0.0 && spring.damping == 0.0) continue;
    const std::uint32_t i = std::min(spring.i, spring.j) - object.first_particle;
    const std::uint32_t j = std::max(spring.i, spring.j) - object.first_particle;
    // The start may be scrambled; rest lengths are not, unless there are none.
    const double length = spring.rest_length > 0.0 ? spring.rest_length
                                                   : (positions.col(j) - positions.col(i)).norm();
    net.pairs.push_back({i, j, length});
  }
  std::sort(net.pairs.begin(), net.pairs.end(), [](const Net::Pair& a, const Net::Pair& b) {
    return std::tie(a.i, a.j, a.length) < std::tie(b.i, b.j, b.length);
  });
  net.pairs.erase(
      std::unique(net.pairs.begin(), net.pairs.end(),
                  [](const Net::Pair& a, const Net::Pair& b) { return a.i == b.i && a.j == b.j; }),
      net.pairs.end());
  if (net.pairs.empty()) return net;
  double sum = 0.0;
  for (const Net::Pair& pair : net.pairs) sum += pair.length;
  // Where all lengths are zero, each pair is one step. Near zero, distances must still add up.
  const double mean = sum > 0.0 ? sum / static_cast<double>(net.pairs.size()) : 1.0;
  for (Net::Pair& pair : net.pairs) pair.length = std::max(pair.length, 1e-3 * mean);
  if (sum == 0.0) {
    for (Net::Pair& pair : net.pairs) pair.length = 1.0;
  }
  if (isSpreadOut(positions, net.pairs)) net.positions = positions;
  return net;
}

Interpolation RestShape::coarsenGrid(Axes& axes) {
  Interpolation result;
  const auto xs = coarsenAxis(axes[0]), ys = coarsenAxis(axes[1]), zs = coarsenAxis(axes[2]);
  const auto nx = static_cast<std::uint32_t>(axes[0].size());
  const auto ny = static_cast<std::uint32_t>(axes[1].size());
  const auto nz = static_cast<std::uint32_t>(axes[2].size());
  result.coarse_size = nx * ny * nz;
  for (const auto& z_entries : zs) {
    for (const auto& y_entries : ys) {
      for (const auto& x_entries : xs) {
        for (const AxisEntry& z : z_entries) {
          for (const AxisEntry& y : y_entries) {
            for (const AxisEntry& x : x_entries) {
              result.entries.push_back({(z.coarse * ny + y.coarse) * nx + x.coarse,
                                        static_cast<float>(z.weight * y.weight * x.weight)});
            }
          }
        }
        result.start.push_back(static_cast<std::uint32_t>(result.entries.size()));
      }
    }
  }
  return result;
}

Interpolation RestShape::coarsen() {
  Interpolation result;
  std::vector<Body> coarse_bodies;
  for (Body& body : bodies_) {
    const bool grid = !body.axes[0].empty();
    const std::size_t size =
        grid ? body.axes[0].size() * body.axes[1].size() * body.axes[2].size() : body.net.size;
    if (!body.coupled || size == 1) {
      result.start.insert(result.start.end(), size, result.start.back());
      continue;
    }
    const Interpolation own = grid ? coarsenGrid(body.axes) : mass_spring::coarsen(body.net);
    const std::uint32_t entries_before = result.start.back();
    for (std::size_t i = 1; i < own.start.size(); ++i) {
      result.start.push_back(entries_before + own.start[i]);
    }
    for (const Interpolation::Entry& entry : own.entries) {
      result.entries.push_back({result.coarse_size + entry.particle, entry.weight});
    }
    result.coarse_size += own.coarse_size;
    if (own.coarse_size > 0) coarse_bodies.push_back(std::move(body));
  }
  bodies_ = std::move(coarse_bodies);
  return result;
}

}  // namespace mass_spring
