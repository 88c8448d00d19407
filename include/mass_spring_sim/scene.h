#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "mass_spring_sim/command.h"
#include "mass_spring_sim/scheme.h"

namespace mass_spring {

/// A scene that was refused. what() holds one problem per line, each `path: got X, expected Y`.
class SceneError : public std::runtime_error {
 public:
  explicit SceneError(std::vector<std::string> problems);
  const std::vector<std::string>& problems() const { return problems_; }

 private:
  std::vector<std::string> problems_;
};

/// A chain of segments + 1 particles from start to end; neighbors are joined.
struct Rope {
  Eigen::Vector3d start, end;            ///< m
  int segments = 1;                      ///< >= 1
  double mass = 0.0;                     ///< kg, whole object, > 0
  std::optional<double> stiffness;       ///< N/m per spring, >= 0; exactly one of these two
  std::optional<double> axial_rigidity;  ///< N (EA), > 0: k = EA / segment length
  std::optional<double> bend_stiffness;  ///< N/m of the skip-one springs
  std::optional<double> damping;         ///< N s/m per spring, >= 0
};

/// resolution[0] x resolution[1] particles in the object's xy plane, centered on position;
/// particle = row * resolution[0] + column, x runs with the column, y with the row.
struct Cloth {
  Eigen::Vector2d size;                                   ///< m, > 0
  std::array<int, 2> resolution{2, 2};                    ///< >= 2 each
  Eigen::Vector3d position = Eigen::Vector3d::Zero();     ///< m
  Eigen::Vector3d orientation = Eigen::Vector3d::Zero();  ///< rad, roll pitch yaw (REP 103)
  double mass = 0.0;                                      ///< kg, whole object, > 0
  double stiffness = 0.0;                                 ///< N/m, structural springs
  std::optional<double> shear_stiffness;                  ///< N/m, both diagonals of each cell
  std::optional<double> bend_stiffness;                   ///< N/m, skip-one springs
  std::optional<double> damping;                          ///< N s/m per spring
};

/// nx x ny x nz particles, centered on position; particle = (iz * ny + iy) * nx + ix.
struct Lattice {
  Eigen::Vector3d size;                                   ///< m, > 0
  std::array<int, 3> resolution{2, 2, 2};                 ///< >= 2 each
  Eigen::Vector3d position = Eigen::Vector3d::Zero();     ///< m
  Eigen::Vector3d orientation = Eigen::Vector3d::Zero();  ///< rad, roll pitch yaw
  double mass = 0.0;                                      ///< kg, whole object, > 0
  double stiffness = 0.0;                                 ///< N/m along the axes
  std::optional<double> shear_stiffness;                  ///< N/m, face and body diagonals
  std::optional<double> bend_stiffness;                   ///< N/m, skip-one along the axes
  std::optional<double> damping;                          ///< N s/m per spring
};

/// One particle per vertex, one structural spring per edge.
struct Mesh {
  std::string file;                                       ///< as the scene names it
  double scale = 1.0;                                     ///< m per unit of the file, > 0
  Eigen::Vector3d position = Eigen::Vector3d::Zero();     ///< m, of the file's origin
  Eigen::Vector3d orientation = Eigen::Vector3d::Zero();  ///< rad, roll pitch yaw
  double mass = 0.0;                                      ///< kg, whole object, > 0
  double stiffness = 0.0;                                 ///< N/m per edge
  std::optional<double> bend_stiffness;   ///< N/m, between opposite corners of adjacent triangles
  std::optional<double> damping;          ///< N s/m per spring
  std::vector<Eigen::Vector3d> vertices;  ///< as in the file, filled by the reader
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< filled by the reader
};

/// Particles and springs given one by one. Where the file has one value for all, the reader has
/// repeated it.
struct Particles {
  std::vector<Eigen::Vector3d> positions;             ///< m, at least one
  std::vector<Eigen::Vector3d> velocities;            ///< m/s, as many as positions
  std::vector<double> masses;                         ///< kg, > 0, as many as positions
  std::vector<std::array<std::uint32_t, 2>> springs;  ///< pairs of different particles
  std::vector<double> stiffness;                      ///< N/m, >= 0, as many as springs
  std::optional<std::vector<double>> damping;         ///< N s/m, >= 0, as many as springs
  std::optional<std::vector<double>> rest_lengths;    ///< m, >= 0; absent = distance at the start
};

struct Object {
  std::string name;                           ///< [A-Za-z][A-Za-z0-9_]*
  Eigen::Vector4d color{0.2, 0.5, 1.0, 1.0};  ///< red green blue alpha, [0, 1] each
  std::variant<Rope, Cloth, Lattice, Mesh, Particles> shape;
};

/// Number of particles the object is built of.
std::uint32_t particleCount(const Object& object);

/// Particles of one object held where they are at the start.
struct ScenePin {
  std::string name;  ///< [A-Za-z][A-Za-z0-9_]*
  std::string object;
  std::vector<std::uint32_t> particles;  ///< of that object, none twice, not empty
  std::string follow_frame = "";         ///< "" = none; without tf, the pin stands still
};

struct GravityOptions {
  Eigen::Vector3d acceleration;  ///< m/s^2
};

struct AirDragOptions {
  double coefficient = 0.0;  ///< N s/m per particle, >= 0
};

/// A gust multiplies the velocity of the wind by 1 + amplitude sin(2 pi t / period).
struct GustOptions {
  double amplitude = 0.0;  ///< >= 0, share of the wind; above 1 the wind reverses at times
  double period = 0.0;     ///< s, > 0
};

/// Air that moves evenly past the faces of cloth and mesh, and through all objects.
struct WindOptions {
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< m/s
  double drag = 0.0;                                   ///< coefficient along the wind, >= 0
  double lift = 0.0;                                   ///< coefficient across it, >= 0
  double density = 1.2;                                ///< kg/m^3 of the air, > 0
  std::optional<GustOptions> gust;                     ///< absent = steady wind
};

/// The half-space behind a plane: the side to which its normal does not point.
struct Plane {
  Eigen::Vector3d point;   ///< m
  Eigen::Vector3d normal;  ///< not 0; its length does not matter
};

struct Sphere {
  Eigen::Vector3d center;  ///< m
  double radius;           ///< m, > 0
};

struct Box {
  Eigen::Vector3d center;                                 ///< m
  Eigen::Vector3d size;                                   ///< m, > 0
  Eigen::Vector3d orientation = Eigen::Vector3d::Zero();  ///< rad, roll pitch yaw
};

/// All points nearer than the radius to the segment from start to end.
struct Capsule {
  Eigen::Vector3d start, end;  ///< m, not the same
  double radius;               ///< m, > 0
};

struct ContactShape {
  std::string name;  ///< [A-Za-z][A-Za-z0-9_]*
  std::variant<Plane, Sphere, Box, Capsule> geometry;
  /// The tf frame to which the shape is fixed and in which its geometry is given. Only the node
  /// knows tf; other programs take the scene's frame instead. Empty = the shape stands in the
  /// scene.
  std::string follow_frame = "";
};

/// Springs keep particles off shapes; friction follows Coulomb's law.
struct ContactOptions {
  double stiffness = 0.0;            ///< N/m per particle, > 0
  double thickness = 0.005;          ///< m, >= 0: distance at which a shape begins to push
  std::optional<double> friction;    ///< >= 0; absent = no friction
  double slip_velocity = 0.001;      ///< m/s, > 0: sticking particles creep more slowly than this
  std::vector<ContactShape> shapes;  ///< in bytewise order of their names, at least one
};

/// Structural and shear springs stiffen beyond a strain.
struct StrainLimitOptions {
  double max_strain = 0.0;        ///< >= 0, length / rest length - 1
  double stiffness_ratio = 10.0;  ///< > 0, extra stiffness beyond / stiffness of the spring
};

/// Structural and shear springs that are stretched beyond a strain break.
struct TearingOptions {
  double max_strain = 0.0;  ///< > 0, length / rest length at the start - 1
};

/// Rest lengths of springs that are strained beyond yielding follow their lengths.
struct PlasticityOptions {
  double yield_strain = 0.0;  ///< >= 0, |length / rest length - 1|
  double creep_rate = 0.0;    ///< 1/s, > 0: rate at which the strain beyond yielding decays
};

/// Cloth, meshes, ropes and particles push themselves and one another apart.
struct SelfCollisionOptions {
  double thickness = 0.0;           ///< m, > 0: distance at which they begin to push
  std::optional<double> stiffness;  ///< N/m per pair, > 0; absent = derived from the springs
};

/// An effect is active if the scene lists it.
struct EffectOptions {
  std::optional<GravityOptions> gravity;
  std::optional<AirDragOptions> air_drag;
  std::optional<WindOptions> wind;
  std::optional<ContactOptions> contact;
  std::optional<StrainLimitOptions> strain_limit;
  std::optional<TearingOptions> tearing;
  std::optional<PlasticityOptions> plasticity;
  std::optional<SelfCollisionOptions> self_collision;
};

struct TimedCommand {
  double time = 0.0;  ///< s of simulated time, >= 0; takes effect at the first step from then on
  Command command;
};

/// Hz of simulated time, [0, 10000]; 0 = never.
struct PublishRates {
  double markers = 30.0;
  double state = 100.0;  ///< the reader's default is the rate of the scene, at most 1000 Hz
  double points = 30.0;
  double pins = 100.0;
  double contacts = 100.0;
  double stats = 10.0;
};

struct Limits {
  double max_force = 1e6;  ///< N per particle, > 0; larger commands are refused
  /// m/s, [1e-6, 1e9]: largest speed at which a command may lead a pin or a shape, and largest
  /// speed in a state that is set. A step in which a particle is kSpeedReserve times as fast has
  /// failed.
  double max_speed = 1e3;
  /// m, [1e-6, 1e9]: largest distance from its start to which a command may lead a pin or a shape.
  /// A step in which a particle is farther than that from its start has failed.
  double max_extent = 1e6;

  static constexpr double kSpeedReserve = 1000.0;
};

/// The reader refuses positions, lengths [m] and start velocities [m/s] with a coordinate above
/// this value, and limits above it. All places that particles and shapes can reach then fit into
/// single precision, with 26 decades to spare.
constexpr double kLargestCoordinate = 1e9;

/// The scene that the user asked for: plain data, validated by the reader. Objects and pins are in
/// bytewise order of their names; the timeline is in order of time, and in the order of the file
/// where times are equal.
struct Scene {
  std::string frame_id = "world";
  double rate = 100.0;            ///< Hz, [1, 10000]; step h = 1 / rate
  double real_time_factor = 1.0;  ///< [0, 100]; 0 = as fast as possible
  bool start_paused = false;
  SolverOptions solver;
  std::vector<Object> objects;  ///< at least one
  std::vector<ScenePin> pins;
  EffectOptions effects;
  std::vector<TimedCommand> timeline;
  PublishRates publish;
  Limits limits;
};

}  // namespace mass_spring
