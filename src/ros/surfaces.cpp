#include "surfaces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

namespace mass_spring {

namespace {

constexpr double kPi = 3.14159265358979323846;

/// Shares of the brightness: everywhere, of the main light and of the weaker one.
constexpr double kAmbient = 0.45, kMain = 0.65, kWeak = 0.25;

}  // namespace

std_msgs::ColorRGBA toColor(const Eigen::Vector3d& rgb, double alpha) {
  std_msgs::ColorRGBA color;
  color.r = static_cast<float>(rgb.x());
  color.g = static_cast<float>(rgb.y());
  color.b = static_cast<float>(rgb.z());
  color.a = static_cast<float>(alpha);
  return color;
}

geometry_msgs::Point toPoint(const Eigen::Vector3d& position) {
  geometry_msgs::Point point;
  point.x = position.x();
  point.y = position.y();
  point.z = position.z();
  return point;
}

Eigen::Vector3d lit(const Eigen::Vector3d& rgb, const Eigen::Vector3d& normal) {
  static const Eigen::Vector3d kToMain = Eigen::Vector3d(0.55, -0.25, 0.8).normalized();
  static const Eigen::Vector3d kToWeak = Eigen::Vector3d(-0.3, 0.9, 0.2).normalized();
  // Half of the cosine is added to a half, so that what is turned away from the light has shades,
  // too.
  const double half = 0.5 + 0.5 * normal.dot(kToMain);
  const double brightness =
      kAmbient + kMain * half * half + kWeak * std::max(0.0, normal.dot(kToWeak));
  return std::min(brightness, 1.0) * rgb;
}

Eigen::Vector3d backColor(const Eigen::Vector3d& front) {
  return 0.45 * front + 0.55 * Eigen::Vector3d(0.95, 0.93, 0.88);
}

Triangles surfaceOf(const Model& model, const ModelObject& object) {
  const auto first = model.triangles.begin() + object.first_triangle;
  Triangles triangles(first, first + object.triangle_count);
  const auto& size = object.resolution;
  if (size[0] < 2 || size[1] < 2 || size[2] < 2) return triangles;

  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (std::uint32_t s = object.first_spring; s < object.first_spring + object.spring_count; ++s) {
    const Spring& spring = model.springs[s];
    if (spring.kind == SpringKind::kStructural) edges.insert(std::minmax(spring.i, spring.j));
  }
  // The two faces across each axis, in turns around it: the one with the larger index
  // counterclockwise if seen from outside.
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (const bool far : {false, true}) {
      std::array<std::uint32_t, 3> at{};
      at[axis] = far ? size[axis] - 1 : 0;
      const auto particle = [&](std::uint32_t du, std::uint32_t dv) {
        std::array<std::uint32_t, 3> i = at;
        i[u] += du;
        i[v] += dv;
        return object.first_particle + (i[2] * size[1] + i[1]) * size[0] + i[0];
      };
      for (at[u] = 0; at[u] + 1 < size[u]; ++at[u]) {
        for (at[v] = 0; at[v] + 1 < size[v]; ++at[v]) {
          std::array<std::uint32_t, 4> cell{particle(0, 0), particle(1, 0), particle(1, 1),
                                            particle(0, 1)};
          if (!far) std::swap(cell[1], cell[3]);
          bool whole = true;
          for (int k = 0; k < 4; ++k) {
            whole = whole && edges.count(std::minmax(cell[k], cell[(k + 1) % 4])) > 0;
          }
          if (!whole) continue;
          triangles.push_back({cell[0], cell[1], cell[2]});
          triangles.push_back({cell[0], cell[2], cell[3]});
        }
      }
    }
  }
  return triangles;
}

Vectors vertexNormals(const Triangles& triangles, const ModelObject& object,
                      const Vectors& positions) {
  Vectors normals = Vectors::Zero(3, object.particle_count);
  for (const auto& triangle : triangles) {
    const Eigen::Vector3d a = positions.col(triangle[0]);
    const Eigen::Vector3d area = Eigen::Vector3d(positions.col(triangle[1]) - a)
                                     .cross(Eigen::Vector3d(positions.col(triangle[2]) - a));
    for (const std::uint32_t particle : triangle) {
      normals.col(particle - object.first_particle) += area;
    }
  }
  for (std::uint32_t i = 0; i < object.particle_count; ++i) {
    const double length = normals.col(i).norm();
    if (length > 0.0) normals.col(i) /= length;
  }
  return normals;
}

bool isClosed(const Triangles& triangles) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges, turned;
  for (const auto& triangle : triangles) {
    for (int k = 0; k < 3; ++k) {
      edges.emplace_back(triangle[k], triangle[(k + 1) % 3]);
      turned.emplace_back(triangle[(k + 1) % 3], triangle[k]);
    }
  }
  std::sort(edges.begin(), edges.end());
  std::sort(turned.begin(), turned.end());
  return edges == turned;
}

void appendTubes(const Model& model, const ModelObject& object, double radius,
                 const Vectors& positions, const Vectors& colors,
                 std::vector<geometry_msgs::Point>& out_points,
                 std::vector<std_msgs::ColorRGBA>& out_colors) {
  std::vector<Spring> springs;
  for (std::uint32_t s = object.first_spring; s < object.first_spring + object.spring_count; ++s) {
    const Spring& spring = model.springs[s];
    if (spring.kind != SpringKind::kStructural) continue;
    if (positions.col(spring.i) != positions.col(spring.j)) springs.push_back(spring);
  }
  // Along the rope at each particle: the mean of the springs that end there.
  Vectors along = Vectors::Zero(3, object.particle_count);
  for (const Spring& spring : springs) {
    const Eigen::Vector3d edge = positions.col(spring.j) - positions.col(spring.i);
    along.col(spring.i - object.first_particle) += edge.normalized();
    along.col(spring.j - object.first_particle) += edge.normalized();
  }
  // Directions across it, carried along the rope so that the tube does not twist.
  Vectors across(3, object.particle_count);
  Eigen::Vector3d tangent = Eigen::Vector3d::UnitX(), normal = Eigen::Vector3d::UnitZ();
  for (std::uint32_t i = 0; i < object.particle_count; ++i) {
    const double length = along.col(i).norm();
    if (length > 0.0) tangent = along.col(i) / length;
    along.col(i) = tangent;
    const Eigen::Vector3d carried = normal - normal.dot(tangent) * tangent;
    normal = carried.norm() > 1e-6 ? carried.normalized() : tangent.unitOrthogonal();
    across.col(i) = normal;
  }
  const auto corner = [&](std::uint32_t particle, std::size_t side) {
    const std::uint32_t i = particle - object.first_particle;
    const double angle = 2.0 * kPi * static_cast<double>(side % kTubeSides) / kTubeSides;
    const Eigen::Vector3d u = across.col(i), t = along.col(i);
    const Eigen::Vector3d outward = std::cos(angle) * u + std::sin(angle) * t.cross(u);
    out_points.push_back(toPoint(positions.col(particle) + radius * outward));
    out_colors.push_back(toColor(lit(colors.col(i), outward), object.color.w()));
  };
  for (const Spring& spring : springs) {
    for (std::size_t side = 0; side < kTubeSides; ++side) {
      corner(spring.i, side);
      corner(spring.i, side + 1);
      corner(spring.j, side + 1);
      corner(spring.i, side);
      corner(spring.j, side + 1);
      corner(spring.j, side);
    }
  }
}

}  // namespace mass_spring
