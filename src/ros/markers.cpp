#include "markers.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mass_spring_sim/measures.h"
#include "surfaces.h"

namespace mass_spring {

namespace {

using visualization_msgs::Marker;

constexpr double kBytesPerSecond = 60e6;
constexpr std::size_t kMarkerBytes = 250;  // all but points and colors, generously
constexpr std::size_t kPointBytes = 24;    // 3 float64
constexpr std::size_t kColorBytes = 16;    // 4 float32

// RViz draws this many spheres easily; more particles become points.
constexpr std::uint32_t kMaxSpheres = 1000;

// Springs are wholly red (stretched) or blue (compressed) from here on.
constexpr double kFullStrain = 0.1;

const Eigen::Vector3d kGray(0.6, 0.6, 0.6), kPinColor(1.0, 0.6, 0.0);

/// From the color at rest to red with strain, to blue with compression.
Eigen::Vector3d strainColor(double strain, const Eigen::Vector3d& at_rest) {
  const Eigen::Vector3d end =
      strain > 0.0 ? Eigen::Vector3d(1.0, 0.1, 0.1) : Eigen::Vector3d(0.1, 0.2, 1.0);
  const double t = std::min(std::abs(strain) / kFullStrain, 1.0);
  return (1.0 - t) * at_rest + t * end;
}

bool drawn(const Spring& spring, Detail detail) {
  return detail == Detail::kFull || spring.kind == SpringKind::kStructural;
}

/// A surface whose back can be seen, through nothing else, has a back of its own color.
bool hasBack(const ModelObject& object, const Triangles& surface) {
  return object.color.w() == 1.0 && !isClosed(surface);
}

/// Particles and springs are there unless a surface takes their place.
bool hasNet(const Triangles& surface, Detail detail) {
  return detail < Detail::kSurface || surface.empty();
}

bool isRope(const ModelObject& object) {
  return object.resolution[0] > 1 && object.resolution[1] == 1 && object.resolution[2] == 1;
}

/// The size of a frame at the most: when all particles are pinned.
/// @param surfaces  one for each object
std::size_t frameBytes(const Model& model, const std::vector<Triangles>& surfaces, Detail detail) {
  std::size_t bytes = 0;
  for (std::size_t o = 0; o < surfaces.size(); ++o) {
    const ModelObject& object = model.objects[o];
    const Triangles& surface = surfaces[o];
    bytes += 4 * kMarkerBytes + object.particle_count * kPointBytes;  // pins
    if (hasNet(surface, detail) || detail == Detail::kPoints) {
      bytes += object.particle_count * kPointBytes;
    }
    if (detail == Detail::kPoints) continue;
    if (hasNet(surface, detail)) {
      const auto first = model.springs.begin() + object.first_spring;
      bytes += std::count_if(first, first + object.spring_count,
                             [&](const Spring& spring) { return drawn(spring, detail); }) *
               2 * (kPointBytes + kColorBytes);
    }
    if (detail == Detail::kSurface) {
      bytes += surface.size() * (3 * kPointBytes + kColorBytes);
    } else {
      const std::size_t corners = isRope(object)
                                      ? (object.particle_count - 1) * 6 * kTubeSides
                                      : surface.size() * 3 * (hasBack(object, surface) ? 2 : 1);
      bytes += corners * (kPointBytes + kColorBytes);
    }
  }
  return bytes;
}

Detail chooseDetail(const Model& model, double rate) {
  std::vector<Triangles> surfaces;
  for (const ModelObject& object : model.objects) surfaces.push_back(surfaceOf(model, object));
  for (const Detail detail : {Detail::kFull, Detail::kStructural, Detail::kSurface}) {
    if (frameBytes(model, surfaces, detail) * rate <= kBytesPerSecond) return detail;
  }
  return Detail::kPoints;
}

/// The diagonal of the box around an object at the start, in m.
double extentOf(const Model& model, const ModelObject& object) {
  const auto start = model.start.positions.middleCols(object.first_particle, object.particle_count);
  return (start.rowwise().maxCoeff() - start.rowwise().minCoeff()).norm();
}

/// Mean length of the structural springs, if there are any, up to a fifth of the object's size.
double spacingOf(const Model& model, const ModelObject& object) {
  const double extent = extentOf(model, object);
  const double largest = extent > 0.0 ? extent / 5.0 : 0.1;
  double sum = 0.0;
  std::size_t count = 0;
  for (std::uint32_t s = 0; s < object.spring_count; ++s) {
    const Spring& spring = model.springs[object.first_spring + s];
    if (spring.kind != SpringKind::kStructural || spring.rest_length <= 0.0) continue;
    sum += spring.rest_length;
    ++count;
  }
  return count > 0 ? std::min(sum / count, largest) : largest;
}

/// Of a rope, in m: as far as it keeps off shapes or itself on both sides, and at least so that it
/// can be seen when all of it is in the picture.
double ropeDiameter(const EffectOptions& effects, double extent) {
  double diameter = extent / 120.0;
  if (effects.contact) diameter = std::max(diameter, 2.0 * effects.contact->thickness);
  if (effects.self_collision) diameter = std::max(diameter, effects.self_collision->thickness);
  return diameter;
}

}  // namespace

Markers::Markers(const Scene& scene, const Model& model, double rate)
    : model_(&model), frame_id_(scene.frame_id), detail_(chooseDetail(model, rate)) {
  for (const ModelObject& object : model.objects) looks_.push_back(look(scene, object));
}

Markers::Look Markers::look(const Scene& scene, const ModelObject& object) const {
  Look look;
  look.spacing = spacingOf(*model_, object);
  const double extent = extentOf(*model_, object);
  const bool tubes = isRope(object) && detail_ < Detail::kSurface;
  look.diameter = tubes ? ropeDiameter(scene.effects, extent) : 0.0;
  look.pin_size = std::max({0.5 * look.spacing, 0.015 * extent, 2.0 * look.diameter});
  const Triangles surface = surfaceOf(*model_, object);
  look.back = hasBack(object, surface) && detail_ < Detail::kSurface;
  look.particles = look.net = look.surface = false;
  if (object.color.w() == 0.0) return look;  // invisible: RViz would take it for a mistake
  look.particles = hasNet(surface, detail_) || detail_ == Detail::kPoints;
  look.net = hasNet(surface, detail_) && detail_ != Detail::kPoints;
  look.surface = (!surface.empty() || tubes) && detail_ != Detail::kPoints;
  chooseParts(object, look);
  look.net = !look.springs.empty();
  return look;
}

void Markers::chooseParts(const ModelObject& object, Look& look) const {
  look.springs.clear();
  if (look.surface) look.triangles = surfaceOf(*model_, object);
  if (!look.net) return;
  for (std::uint32_t s = object.first_spring; s < object.first_spring + object.spring_count; ++s) {
    if (drawn(model_->springs[s], detail_)) look.springs.push_back(s);
  }
}

void Markers::follow(const Model& model) {
  model_ = &model;
  for (std::size_t o = 0; o < looks_.size(); ++o) chooseParts(model.objects[o], looks_[o]);
}

const visualization_msgs::MarkerArray& Markers::draw(const Vectors& positions,
                                                     const std::vector<char>& pinned,
                                                     const ros::Time& stamp, bool start_over,
                                                     std::vector<Marker> shapes) {
  array_.markers.resize(4 * model_->objects.size() + 1);
  used_ = 0;
  if (start_over) {
    Marker& marker = array_.markers[used_++];
    marker = Marker();
    marker.header.frame_id = frame_id_;
    marker.header.stamp = stamp;
    marker.action = Marker::DELETEALL;
    marker.pose.orientation.w = 1.0;
  }
  for (std::size_t o = 0; o < looks_.size(); ++o) {
    const ModelObject& object = model_->objects[o];
    const Look& look = looks_[o];
    if (look.particles) drawParticles(object, look, positions, stamp);
    if (look.net) drawSprings(object, look, positions, stamp);
    if (look.surface) drawSurface(object, look, positions, stamp);
    drawPins(object, look, positions, pinned, stamp);
  }
  array_.markers.resize(used_);
  for (Marker& shape : shapes) array_.markers.push_back(std::move(shape));
  return array_;
}

visualization_msgs::Marker& Markers::next(const std::string& ns, int type,
                                          const ModelObject& object, const ros::Time& stamp) {
  Marker& marker = array_.markers[used_++];
  marker.header.frame_id = frame_id_;
  marker.header.stamp = stamp;
  marker.ns = object.name + "/" + ns;
  marker.id = 0;
  marker.type = type;
  marker.action = Marker::ADD;
  marker.pose.orientation.w = 1.0;
  marker.color = toColor(object.color.head<3>(), object.color.w());
  marker.points.clear();
  marker.colors.clear();
  return marker;
}

void Markers::drawParticles(const ModelObject& object, const Look& look, const Vectors& positions,
                            const ros::Time& stamp) {
  const bool spheres = object.particle_count <= kMaxSpheres && detail_ != Detail::kPoints;
  Marker& marker = next("particles", spheres ? Marker::SPHERE_LIST : Marker::POINTS, object, stamp);
  marker.scale.x = marker.scale.y = marker.scale.z = 0.3 * look.spacing;
  marker.points.reserve(object.particle_count);
  for (std::uint32_t i = 0; i < object.particle_count; ++i) {
    marker.points.push_back(toPoint(positions.col(object.first_particle + i)));
  }
}

void Markers::drawSprings(const ModelObject& object, const Look& look, const Vectors& positions,
                          const ros::Time& stamp) {
  Marker& marker = next("springs", Marker::LINE_LIST, object, stamp);
  marker.scale.x = 0.08 * look.spacing;
  marker.scale.y = marker.scale.z = 0.0;
  marker.points.reserve(2 * look.springs.size());
  marker.colors.reserve(2 * look.springs.size());
  for (const std::uint32_t s : look.springs) {
    const Spring& spring = model_->springs[s];
    marker.points.push_back(toPoint(positions.col(spring.i)));
    marker.points.push_back(toPoint(positions.col(spring.j)));
    const Eigen::Vector3d color = strainColor(strain(spring, positions), kGray);
    marker.colors.insert(marker.colors.end(), 2, toColor(color, object.color.w()));
  }
  if (marker.points.empty()) marker.action = Marker::DELETE;
}

void Markers::drawSurface(const ModelObject& object, const Look& look, const Vectors& positions,
                          const ros::Time& stamp) {
  Marker& marker = next("surface", Marker::TRIANGLE_LIST, object, stamp);
  marker.scale.x = marker.scale.y = marker.scale.z = 1.0;
  const Vectors colors = particleColors(object, positions);
  if (look.diameter > 0.0) {
    appendTubes(*model_, object, 0.5 * look.diameter, positions, colors, marker.points,
                marker.colors);
  } else {
    drawTriangles(object, look, positions, colors, marker);
  }
  if (marker.points.empty()) marker.action = Marker::DELETE;
}

void Markers::drawTriangles(const ModelObject& object, const Look& look, const Vectors& positions,
                            const Vectors& colors, Marker& marker) const {
  const Vectors normals = vertexNormals(look.triangles, object, positions);
  const double alpha = object.color.w();
  marker.points.reserve(3 * look.triangles.size() * (look.back ? 2 : 1));
  const auto corner = [&](std::uint32_t particle, double side) {
    const std::uint32_t i = particle - object.first_particle;
    const Eigen::Vector3d normal = side * normals.col(i), front = colors.col(i);
    // Both sides at the same depth would flicker.
    const double offset = look.back ? 0.02 * look.spacing : 0.0;
    marker.points.push_back(toPoint(positions.col(particle) + offset * normal));
    marker.colors.push_back(toColor(lit(side > 0.0 ? front : backColor(front), normal), alpha));
  };
  for (const auto& triangle : look.triangles) {
    if (detail_ == Detail::kSurface) {
      Eigen::Vector3d color = Eigen::Vector3d::Zero();
      for (const std::uint32_t particle : triangle) {
        const std::uint32_t i = particle - object.first_particle;
        marker.points.push_back(toPoint(positions.col(particle)));
        // Seen from either side: as bright as the side that is lit.
        const Eigen::Vector3d front = lit(colors.col(i), normals.col(i));
        color += front.cwiseMax(lit(colors.col(i), -normals.col(i))) / 3.0;
      }
      // RViz takes one color per triangle, a third of the size of one per corner.
      marker.colors.push_back(toColor(color, alpha));
      continue;
    }
    for (const std::uint32_t particle : triangle) corner(particle, 1.0);
    if (!look.back) continue;
    for (const int k : {0, 2, 1}) corner(triangle[k], -1.0);
  }
}

Vectors Markers::particleColors(const ModelObject& object, const Vectors& positions) const {
  Eigen::VectorXd strains = Eigen::VectorXd::Zero(object.particle_count);
  Eigen::VectorXd counts = Eigen::VectorXd::Zero(object.particle_count);
  for (std::uint32_t s = object.first_spring; s < object.first_spring + object.spring_count; ++s) {
    const Spring& spring = model_->springs[s];
    if (spring.kind != SpringKind::kStructural) continue;
    const double value = strain(spring, positions);
    for (const std::uint32_t end : {spring.i, spring.j}) {
      strains[end - object.first_particle] += value;
      ++counts[end - object.first_particle];
    }
  }
  Vectors colors(3, object.particle_count);
  for (std::uint32_t i = 0; i < object.particle_count; ++i) {
    colors.col(i) = strainColor(strains[i] / std::max(counts[i], 1.0), object.color.head<3>());
  }
  return colors;
}

void Markers::drawPins(const ModelObject& object, const Look& look, const Vectors& positions,
                       const std::vector<char>& pinned, const ros::Time& stamp) {
  Marker& marker = next("pins", Marker::SPHERE_LIST, object, stamp);
  marker.scale.x = marker.scale.y = marker.scale.z = look.pin_size;
  marker.color = toColor(kPinColor, 1.0);
  for (std::uint32_t i = 0; i < object.particle_count; ++i) {
    const std::uint32_t particle = object.first_particle + i;
    if (pinned[particle]) marker.points.push_back(toPoint(positions.col(particle)));
  }
  marker.action = marker.points.empty() ? Marker::DELETE : Marker::ADD;
}

}  // namespace mass_spring
