#include "markers.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mass_spring_sim/measures.h"

namespace mass_spring {

namespace {

using visualization_msgs::Marker;

constexpr double kBytesPerSecond = 60e6;
constexpr std::size_t kMarkerBytes = 250;  // all but points and colours, generously
constexpr std::size_t kPointBytes = 24;    // 3 float64
constexpr std::size_t kColorBytes = 16;    // 4 float32

// RViz draws this many spheres easily; more particles become points.
constexpr std::uint32_t kMaxSpheres = 1000;

// Springs are wholly red (stretched) or blue (compressed) from here on.
constexpr double kFullStrain = 0.1;

std_msgs::ColorRGBA color(double red, double green, double blue, double alpha) {
  std_msgs::ColorRGBA color;
  color.r = static_cast<float>(red);
  color.g = static_cast<float>(green);
  color.b = static_cast<float>(blue);
  color.a = static_cast<float>(alpha);
  return color;
}

/// From the colour at rest to red with strain, to blue with compression.
std_msgs::ColorRGBA strainColor(double strain, const Eigen::Vector4d& at_rest) {
  const Eigen::Vector3d end =
      strain > 0.0 ? Eigen::Vector3d(1.0, 0.1, 0.1) : Eigen::Vector3d(0.1, 0.2, 1.0);
  const double t = std::min(std::abs(strain) / kFullStrain, 1.0);
  const Eigen::Vector3d mixed = (1.0 - t) * at_rest.head<3>() + t * end;
  return color(mixed.x(), mixed.y(), mixed.z(), at_rest.w());
}

geometry_msgs::Point point(const Vectors& positions, std::uint32_t particle) {
  geometry_msgs::Point point;
  point.x = positions(0, particle);
  point.y = positions(1, particle);
  point.z = positions(2, particle);
  return point;
}

bool drawn(const Spring& spring, Detail detail) {
  return detail == Detail::kFull || spring.kind == SpringKind::kStructural;
}

/// Particles and springs are there unless a surface takes their place.
bool hasNet(const ModelObject& object, Detail detail) {
  return detail < Detail::kSurface || !object.has_surface;
}

/// What a frame takes at the most: when all particles are pinned.
std::size_t frameBytes(const Model& model, Detail detail) {
  std::size_t bytes = 0;
  for (const ModelObject& object : model.objects) {
    bytes += 4 * kMarkerBytes + object.particle_count * kPointBytes;  // pins
    if (hasNet(object, detail) || detail == Detail::kPoints) {
      bytes += object.particle_count * kPointBytes;
    }
    if (detail == Detail::kPoints) continue;
    if (hasNet(object, detail)) {
      const auto first = model.springs.begin() + object.first_spring;
      bytes += std::count_if(first, first + object.spring_count,
                             [&](const Spring& spring) { return drawn(spring, detail); }) *
               2 * (kPointBytes + kColorBytes);
    }
    if (object.has_surface) {
      const std::size_t color_bytes = detail == Detail::kSurface ? kColorBytes : 0;
      bytes += object.triangle_count * (3 * kPointBytes + color_bytes);
    }
  }
  return bytes;
}

Detail chooseDetail(const Model& model, double rate) {
  for (const Detail detail : {Detail::kFull, Detail::kStructural, Detail::kSurface}) {
    if (frameBytes(model, detail) * rate <= kBytesPerSecond) return detail;
  }
  return Detail::kPoints;
}

/// Mean length of the structural springs, if there are any, up to a fifth of the object's size.
double spacing(const Model& model, const ModelObject& object) {
  const auto start = model.start.positions.middleCols(object.first_particle, object.particle_count);
  const double extent = (start.rowwise().maxCoeff() - start.rowwise().minCoeff()).norm();
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

}  // namespace

Markers::Markers(const Model& model, std::string frame_id, double rate)
    : model_(&model), frame_id_(std::move(frame_id)), detail_(chooseDetail(model, rate)) {
  for (const ModelObject& object : model.objects) looks_.push_back(look(object));
}

Markers::Look Markers::look(const ModelObject& object) const {
  Look look;
  look.spacing = spacing(*model_, object);
  look.particles = look.net = look.surface = false;
  if (object.color.w() == 0.0) return look;  // invisible: RViz would take it for a mistake
  look.particles = hasNet(object, detail_) || detail_ == Detail::kPoints;
  look.net = hasNet(object, detail_) && detail_ != Detail::kPoints;
  look.surface = object.triangle_count > 0 && detail_ != Detail::kPoints;
  chooseSprings(object, look);
  look.net = !look.springs.empty();
  return look;
}

void Markers::chooseSprings(const ModelObject& object, Look& look) const {
  look.springs.clear();
  look.edge_lengths.clear();
  if (look.net) {
    for (std::uint32_t s = object.first_spring; s < object.first_spring + object.spring_count;
         ++s) {
      if (drawn(model_->springs[s], detail_)) look.springs.push_back(s);
    }
  }
  if (look.surface && detail_ == Detail::kSurface) {
    for (std::uint32_t t = 0; t < object.triangle_count; ++t) {
      const auto& triangle = model_->triangles[object.first_triangle + t];
      for (int k = 0; k < 3; ++k) {
        look.edge_lengths.push_back((model_->start.positions.col(triangle[(k + 1) % 3]) -
                                     model_->start.positions.col(triangle[k]))
                                        .norm());
      }
    }
  }
}

void Markers::follow(const Model& model) {
  model_ = &model;
  for (std::size_t o = 0; o < looks_.size(); ++o) chooseSprings(model.objects[o], looks_[o]);
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
  marker.color = color(object.color.x(), object.color.y(), object.color.z(), object.color.w());
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
    marker.points.push_back(point(positions, object.first_particle + i));
  }
}

void Markers::drawSprings(const ModelObject& object, const Look& look, const Vectors& positions,
                          const ros::Time& stamp) {
  Marker& marker = next("springs", Marker::LINE_LIST, object, stamp);
  marker.scale.x = 0.08 * look.spacing;
  marker.scale.y = marker.scale.z = 0.0;
  marker.points.reserve(2 * look.springs.size());
  marker.colors.reserve(2 * look.springs.size());
  const Eigen::Vector4d grey(0.6, 0.6, 0.6, object.color.w());
  for (const std::uint32_t s : look.springs) {
    const Spring& spring = model_->springs[s];
    marker.points.push_back(point(positions, spring.i));
    marker.points.push_back(point(positions, spring.j));
    marker.colors.insert(marker.colors.end(), 2, strainColor(strain(spring, positions), grey));
  }
  if (marker.points.empty()) marker.action = Marker::DELETE;
}

void Markers::drawSurface(const ModelObject& object, const Look& look, const Vectors& positions,
                          const ros::Time& stamp) {
  Marker& marker = next("surface", Marker::TRIANGLE_LIST, object, stamp);
  marker.scale.x = marker.scale.y = marker.scale.z = 1.0;
  marker.points.reserve(3 * object.triangle_count);
  for (std::uint32_t t = 0; t < object.triangle_count; ++t) {
    const auto& triangle = model_->triangles[object.first_triangle + t];
    for (const std::uint32_t particle : triangle)
      marker.points.push_back(point(positions, particle));
    if (look.edge_lengths.empty()) continue;
    double largest = 0.0;  // in magnitude, of the three edges
    for (int k = 0; k < 3; ++k) {
      const double start = look.edge_lengths[3 * t + k];
      if (start == 0.0) continue;
      const double length =
          (positions.col(triangle[(k + 1) % 3]) - positions.col(triangle[k])).norm();
      const double strain = length / start - 1.0;
      if (std::abs(strain) > std::abs(largest)) largest = strain;
    }
    // RViz takes one colour per triangle, a third of what one per corner would cost.
    marker.colors.push_back(strainColor(largest, object.color));
  }
  if (marker.points.empty()) marker.action = Marker::DELETE;
}

void Markers::drawPins(const ModelObject& object, const Look& look, const Vectors& positions,
                       const std::vector<char>& pinned, const ros::Time& stamp) {
  Marker& marker = next("pins", Marker::SPHERE_LIST, object, stamp);
  marker.scale.x = marker.scale.y = marker.scale.z = 0.5 * look.spacing;
  marker.color = color(1.0, 0.6, 0.0, 1.0);
  for (std::uint32_t i = 0; i < object.particle_count; ++i) {
    const std::uint32_t particle = object.first_particle + i;
    if (pinned[particle]) marker.points.push_back(point(positions, particle));
  }
  marker.action = marker.points.empty() ? Marker::DELETE : Marker::ADD;
}

}  // namespace mass_spring
