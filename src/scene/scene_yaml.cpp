#include <yaml-cpp/emitter.h>
#include <yaml-cpp/emittermanip.h>

#include "mass_spring_sim/scene_reader.h"
#include "scene/scalar.h"
#include "scene/tree_reader.h"

namespace mass_spring {
namespace {

/// Writes the maps, lists and scalars of a scene so that rosparam and readYamlText read them alike.
class Writer {
 public:
  void begin() { out_ << YAML::BeginMap; }
  void begin(const std::string& key) {
    writeKey(key);
    begin();
  }
  void end() { out_ << YAML::EndMap; }
  std::string text() const { return out_.c_str(); }

  template <typename T>
  void add(const std::string& key, const T& value) {
    writeKey(key);
    write(value);
  }
  template <typename T>
  void add(const std::string& key, const std::optional<T>& value) {
    if (value) add(key, *value);
  }
  /// A list of maps; `writeElement` writes what is in the map of one element.
  template <typename T, typename Function>
  void addMaps(const std::string& key, const std::vector<T>& elements, Function writeElement) {
    writeKey(key);
    out_ << YAML::BeginSeq;
    for (const T& element : elements) {
      begin();
      writeElement(element);
      end();
    }
    out_ << YAML::EndSeq;
  }

 private:
  void writeKey(const std::string& key) {
    out_ << YAML::Key;
    write(key);
    out_ << YAML::Value;
  }
  void write(bool value) { out_ << (value ? "true" : "false"); }
  void write(int value) { out_ << value; }
  void write(std::uint32_t value) { out_ << value; }
  void write(double value) { out_ << formatNumber(value); }
  void write(const char* text) { write(std::string(text)); }
  /// In quotes unless it is a name that means nothing else: an object may be called "on".
  void write(const std::string& text) {
    const bool plain =
        isName(text) && std::holds_alternative<std::string>(resolvePlainScalar(text).value);
    if (!plain) out_ << YAML::DoubleQuoted;
    out_ << text;
  }
  template <typename T>
  void writeList(const T& elements) {
    out_ << YAML::Flow << YAML::BeginSeq;
    for (const auto& element : elements) write(element);
    out_ << YAML::EndSeq;
  }
  template <int n>
  void write(const Eigen::Matrix<double, n, 1>& vector) {
    writeList(std::vector<double>(vector.data(), vector.data() + n));
  }
  template <typename T>
  void write(const std::vector<T>& elements) {
    writeList(elements);
  }
  template <typename T, std::size_t n>
  void write(const std::array<T, n>& elements) {
    writeList(elements);
  }

  YAML::Emitter out_;
};

void writeShape(Writer& yaml, const Rope& rope) {
  yaml.add("type", "rope");
  yaml.add("start", rope.start);
  yaml.add("end", rope.end);
  yaml.add("segments", rope.segments);
  yaml.add("mass", rope.mass);
  yaml.add("stiffness", rope.stiffness);
  yaml.add("axial_rigidity", rope.axial_rigidity);
  yaml.add("bend_stiffness", rope.bend_stiffness);
  yaml.add("damping", rope.damping);
}

template <typename Grid>
void writeGrid(Writer& yaml, const char* type, const Grid& grid) {
  yaml.add("type", type);
  yaml.add("size", grid.size);
  yaml.add("resolution", grid.resolution);
  yaml.add("position", grid.position);
  yaml.add("orientation", grid.orientation);
  yaml.add("mass", grid.mass);
  yaml.add("stiffness", grid.stiffness);
  yaml.add("shear_stiffness", grid.shear_stiffness);
  yaml.add("bend_stiffness", grid.bend_stiffness);
  yaml.add("damping", grid.damping);
}

void writeShape(Writer& yaml, const Cloth& cloth) { writeGrid(yaml, "cloth", cloth); }

void writeShape(Writer& yaml, const Lattice& lattice) { writeGrid(yaml, "lattice", lattice); }

void writeShape(Writer& yaml, const Mesh& mesh) {
  yaml.add("type", "mesh");
  yaml.add("file", mesh.file);
  yaml.add("scale", mesh.scale);
  yaml.add("position", mesh.position);
  yaml.add("orientation", mesh.orientation);
  yaml.add("mass", mesh.mass);
  yaml.add("stiffness", mesh.stiffness);
  yaml.add("bend_stiffness", mesh.bend_stiffness);
  yaml.add("damping", mesh.damping);
}

void writeShape(Writer& yaml, const Particles& particles) {
  yaml.add("type", "particles");
  yaml.add("positions", particles.positions);
  yaml.add("velocities", particles.velocities);
  yaml.add("masses", particles.masses);
  yaml.add("springs", particles.springs);
  yaml.add("stiffness", particles.stiffness);
  yaml.add("damping", particles.damping);
  yaml.add("rest_lengths", particles.rest_lengths);
}

void writeCommand(Writer& yaml, const ForceCommand& command) {
  yaml.begin("force");
  yaml.add("id", command.id);
  yaml.add("object", command.object);
  yaml.add("particles", command.particles);
  yaml.add("forces", command.forces);
  yaml.add("duration", command.duration);
  yaml.end();
}

void writeCommand(Writer& yaml, const PinCommand& command) {
  using Action = PinCommand::Action;
  yaml.begin("pin");
  yaml.add("action", command.action == Action::kAdd    ? "add"
                     : command.action == Action::kMove ? "move"
                                                       : "remove");
  yaml.add("name", command.name);
  if (command.action == Action::kAdd) {
    yaml.add("object", command.object);
    if (command.particles.empty()) {
      yaml.add("point", command.point);
      yaml.add("radius", command.radius);
    } else {
      yaml.add("particles", command.particles);
    }
  }
  if (command.action == Action::kMove || (command.action == Action::kAdd && !command.here)) {
    yaml.add("target", command.target.position);
    const Eigen::Vector4d orientation = command.target.orientation.coeffs();
    yaml.add("orientation", orientation);
  }
  if (!command.follow_frame.empty()) yaml.add("follow_frame", command.follow_frame);
  yaml.end();
}

void writeCommand(Writer& yaml, const ShapeCommand& command) {
  yaml.begin("shape");
  yaml.add("name", command.name);
  yaml.add("target", command.target.position);
  const Eigen::Vector4d orientation = command.target.orientation.coeffs();
  yaml.add("orientation", orientation);
  yaml.add("duration", command.duration);
  yaml.end();
}

void writeCommand(Writer& yaml, const ClearCommand& command) {
  yaml.add("clear", command.what == ClearCommand::What::kForces ? "forces" : "pins");
}

void writeSolver(Writer& yaml, const SolverOptions& solver) {
  yaml.begin("solver");
  yaml.add("scheme", name(solver.scheme));
  yaml.add("substeps", solver.substeps);
  yaml.add("newton_tolerance", solver.newton_tolerance);
  yaml.add("max_newton_iterations", solver.max_newton_iterations);
  yaml.add("linear_solver", name(solver.linear_solver));
  yaml.add("linear_tolerance", solver.linear_tolerance);
  yaml.add("max_linear_iterations", solver.max_linear_iterations);
  yaml.add("accuracy", solver.accuracy);
  if (!solver.calibration_file.empty()) yaml.add("calibration", solver.calibration_file);
  yaml.add("budget", solver.budget);
  yaml.add("threads", solver.threads);
  yaml.end();
}

void writeObjects(Writer& yaml, const std::vector<Object>& objects) {
  yaml.begin("objects");
  for (const Object& object : objects) {
    yaml.begin(object.name);
    std::visit([&](const auto& shape) { writeShape(yaml, shape); }, object.shape);
    yaml.add("color", object.color);
    yaml.end();
  }
  yaml.end();
}

void writePins(Writer& yaml, const std::vector<ScenePin>& pins) {
  yaml.begin("pins");
  for (const ScenePin& pin : pins) {
    yaml.begin(pin.name);
    yaml.add("object", pin.object);
    yaml.add("particles", pin.particles);
    if (!pin.follow_frame.empty()) yaml.add("follow_frame", pin.follow_frame);
    yaml.end();
  }
  yaml.end();
}

void writeGeometry(Writer& yaml, const Plane& plane) {
  yaml.add("type", "plane");
  yaml.add("point", plane.point);
  yaml.add("normal", plane.normal);
}

void writeGeometry(Writer& yaml, const Sphere& sphere) {
  yaml.add("type", "sphere");
  yaml.add("center", sphere.center);
  yaml.add("radius", sphere.radius);
}

void writeGeometry(Writer& yaml, const Box& box) {
  yaml.add("type", "box");
  yaml.add("center", box.center);
  yaml.add("size", box.size);
  yaml.add("orientation", box.orientation);
}

void writeGeometry(Writer& yaml, const Capsule& capsule) {
  yaml.add("type", "capsule");
  yaml.add("start", capsule.start);
  yaml.add("end", capsule.end);
  yaml.add("radius", capsule.radius);
}

void writeWind(Writer& yaml, const WindOptions& wind) {
  yaml.begin("wind");
  yaml.add("velocity", wind.velocity);
  yaml.add("drag", wind.drag);
  yaml.add("lift", wind.lift);
  yaml.add("density", wind.density);
  if (wind.gust) {
    yaml.begin("gust");
    yaml.add("amplitude", wind.gust->amplitude);
    yaml.add("period", wind.gust->period);
    yaml.end();
  }
  yaml.end();
}

void writeContact(Writer& yaml, const ContactOptions& contact) {
  yaml.begin("contact");
  yaml.add("stiffness", contact.stiffness);
  yaml.add("thickness", contact.thickness);
  yaml.add("friction", contact.friction);
  yaml.add("slip_velocity", contact.slip_velocity);
  yaml.begin("shapes");
  for (const ContactShape& shape : contact.shapes) {
    yaml.begin(shape.name);
    std::visit([&](const auto& geometry) { writeGeometry(yaml, geometry); }, shape.geometry);
    if (!shape.follow_frame.empty()) yaml.add("follow_frame", shape.follow_frame);
    yaml.end();
  }
  yaml.end();
  yaml.end();
}

void writeEffects(Writer& yaml, const EffectOptions& effects) {
  yaml.begin("effects");
  if (effects.gravity) {
    yaml.begin("gravity");
    yaml.add("acceleration", effects.gravity->acceleration);
    yaml.end();
  }
  if (effects.air_drag) {
    yaml.begin("air_drag");
    yaml.add("coefficient", effects.air_drag->coefficient);
    yaml.end();
  }
  if (effects.wind) writeWind(yaml, *effects.wind);
  if (effects.contact) writeContact(yaml, *effects.contact);
  if (effects.strain_limit) {
    yaml.begin("strain_limit");
    yaml.add("max_strain", effects.strain_limit->max_strain);
    yaml.add("stiffness_ratio", effects.strain_limit->stiffness_ratio);
    yaml.end();
  }
  if (effects.tearing) {
    yaml.begin("tearing");
    yaml.add("max_strain", effects.tearing->max_strain);
    yaml.end();
  }
  if (effects.plasticity) {
    yaml.begin("plasticity");
    yaml.add("yield_strain", effects.plasticity->yield_strain);
    yaml.add("creep_rate", effects.plasticity->creep_rate);
    yaml.end();
  }
  if (effects.self_collision) {
    yaml.begin("self_collision");
    yaml.add("thickness", effects.self_collision->thickness);
    yaml.add("stiffness", effects.self_collision->stiffness);
    yaml.end();
  }
  yaml.end();
}

}  // namespace

std::string toYaml(const Scene& scene) {
  Writer yaml;
  yaml.begin();
  yaml.add("frame_id", scene.frame_id);
  yaml.add("rate", scene.rate);
  yaml.add("real_time_factor", scene.real_time_factor);
  yaml.add("start_paused", scene.start_paused);
  writeSolver(yaml, scene.solver);
  writeObjects(yaml, scene.objects);
  writePins(yaml, scene.pins);
  writeEffects(yaml, scene.effects);
  yaml.addMaps("timeline", scene.timeline, [&](const TimedCommand& timed) {
    yaml.add("time", timed.time);
    std::visit([&](const auto& command) { writeCommand(yaml, command); }, timed.command);
  });
  yaml.begin("publish");
  yaml.add("markers", scene.publish.markers);
  yaml.add("state", scene.publish.state);
  yaml.add("points", scene.publish.points);
  yaml.add("pins", scene.publish.pins);
  yaml.add("contacts", scene.publish.contacts);
  yaml.add("stats", scene.publish.stats);
  yaml.end();
  yaml.begin("limits");
  yaml.add("max_force", scene.limits.max_force);
  yaml.add("max_speed", scene.limits.max_speed);
  yaml.add("max_extent", scene.limits.max_extent);
  yaml.end();
  yaml.end();
  return yaml.text() + "\n";
}

}  // namespace mass_spring
