#include "scene/effects_reader.h"

#include <algorithm>

#include "scene/references.h"

namespace mass_spring {
namespace {

void readDirection(const Place& place, Eigen::Vector3d& direction) {
  const bool read = place.read(direction, anyNumber(""));
  if (read && !(direction.norm() > 0.0)) place.refuse("a direction that is not 0");
}

void readGeometry(std::size_t type, MapReader& keys, ContactShape& shape) {
  if (type == 0) {
    Plane& plane = shape.geometry.emplace<Plane>();
    readPosition(keys.required("point"), plane.point);
    readDirection(keys.required("normal"), plane.normal);
  } else if (type == 1) {
    Sphere& sphere = shape.geometry.emplace<Sphere>();
    readPosition(keys.required("center"), sphere.center);
    readSize(keys.required("radius"), sphere.radius);
  } else if (type == 2) {
    Box& box = shape.geometry.emplace<Box>();
    readPosition(keys.required("center"), box.center);
    readSize(keys.required("size"), box.size);
    keys.optional("orientation").read(box.orientation, anyNumber("rad"));
  } else {
    Capsule& capsule = shape.geometry.emplace<Capsule>();
    const bool has_start = readPosition(keys.required("start"), capsule.start);
    const Place end = keys.required("end");
    const bool has_end = readPosition(end, capsule.end);
    if (has_start && has_end && capsule.start == capsule.end) {
      end.report("the start", "another point; for a ball: type: sphere");
    }
    readSize(keys.required("radius"), capsule.radius);
  }
}

void readShapes(const Place& place, std::vector<ContactShape>& shapes) {
  static const std::vector<std::string> kTypes = {"plane", "sphere", "box", "capsule"};
  const std::string expected = "a map of at least one shape";
  const Tree::Map* map = place.map(expected);
  if (map == nullptr) return;
  if (map->empty()) return place.refuse(expected);
  for (const auto& [name, tree] : *map) {
    const Place entry = place.child(name, true);
    if (!isName(name)) entry.report(name, kNameRule);
    ContactShape shape;
    shape.name = name;
    MapReader keys(entry, "a map with type");
    std::size_t type = 0;
    if (!keys.required("type").read(type, kTypes)) continue;
    readGeometry(type, keys, shape);
    readFrame(keys.optional("follow_frame"), shape.follow_frame);
    keys.refuseUnknown();
    shapes.push_back(std::move(shape));
  }
}

void readWind(const Place& place, WindOptions& wind) {
  MapReader keys(place, "a map with velocity and drag");
  keys.required("velocity").read(wind.velocity, anyNumber("m/s"));
  keys.required("drag").read(wind.drag, atLeastZero(""));
  keys.optional("lift").read(wind.lift, atLeastZero(""));
  keys.optional("density").read(wind.density, positive("kg/m^3"));
  if (const Place gust = keys.optional("gust"); gust.present()) {
    wind.gust.emplace();
    MapReader options(gust, "a map with amplitude and period");
    options.required("amplitude").read(wind.gust->amplitude, atLeastZero(""));
    options.required("period").read(wind.gust->period, positive("s"));
    options.refuseUnknown();
  }
  keys.refuseUnknown();
}

bool hasFaces(const Object& object) {
  return std::holds_alternative<Cloth>(object.shape) || std::holds_alternative<Mesh>(object.shape);
}

}  // namespace

void readEffects(const Place& place, const std::vector<Object>* objects, EffectOptions& effects) {
  MapReader keys(place, "a map of effects");
  if (const Place gravity = keys.optional("gravity"); gravity.present()) {
    effects.gravity.emplace();
    MapReader options(gravity, "a map with acceleration");
    options.required("acceleration").read(effects.gravity->acceleration, anyNumber("m/s^2"));
    options.refuseUnknown();
  }
  if (const Place drag = keys.optional("air_drag"); drag.present()) {
    effects.air_drag.emplace();
    MapReader options(drag, "a map with coefficient");
    options.required("coefficient").read(effects.air_drag->coefficient, atLeastZero("N s/m"));
    options.refuseUnknown();
  }
  if (const Place wind = keys.optional("wind"); wind.present()) {
    readWind(wind, effects.wind.emplace());
    if (objects != nullptr && std::none_of(objects->begin(), objects->end(), hasFaces)) {
      wind.report("a scene without faces", "an object of type cloth or mesh to blow on");
    }
  }
  if (const Place contact = keys.optional("contact"); contact.present()) {
    ContactOptions& options = effects.contact.emplace();
    MapReader reader(contact, "a map with stiffness and shapes");
    reader.required("stiffness").read(options.stiffness, positive("N/m"));
    reader.optional("thickness").read(options.thickness, atLeastZero("m"));
    reader.optional("friction").read(options.friction, atLeastZero(""));
    reader.optional("slip_velocity").read(options.slip_velocity, positive("m/s"));
    readShapes(reader.required("shapes"), options.shapes);
    reader.refuseUnknown();
  }
  if (const Place limit = keys.optional("strain_limit"); limit.present()) {
    StrainLimitOptions& options = effects.strain_limit.emplace();
    MapReader reader(limit, "a map with max_strain");
    reader.required("max_strain").read(options.max_strain, atLeastZero(""));
    reader.optional("stiffness_ratio").read(options.stiffness_ratio, positive(""));
    reader.refuseUnknown();
  }
  if (const Place tearing = keys.optional("tearing"); tearing.present()) {
    MapReader reader(tearing, "a map with max_strain");
    reader.required("max_strain").read(effects.tearing.emplace().max_strain, positive(""));
    reader.refuseUnknown();
  }
  if (const Place plasticity = keys.optional("plasticity"); plasticity.present()) {
    PlasticityOptions& options = effects.plasticity.emplace();
    MapReader reader(plasticity, "a map with yield_strain and creep_rate");
    reader.required("yield_strain").read(options.yield_strain, atLeastZero(""));
    reader.required("creep_rate").read(options.creep_rate, positive("1/s"));
    reader.refuseUnknown();
  }
  if (const Place collision = keys.optional("self_collision"); collision.present()) {
    SelfCollisionOptions& options = effects.self_collision.emplace();
    MapReader reader(collision, "a map with thickness");
    reader.required("thickness").read(options.thickness, positive("m"));
    reader.optional("stiffness").read(options.stiffness, positive("N/m"));
    reader.refuseUnknown();
  }
  keys.refuseUnknown();
}

}  // namespace mass_spring
