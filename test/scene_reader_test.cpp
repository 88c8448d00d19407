#include "mass_spring_sim/scene_reader.h"

#include <gtest/gtest.h>

#include "scene_text.h"

namespace mass_spring {
namespace {

using Lines = std::vector<std::string>;

Scene read(const Tree& tree) { return readScene(tree, ""); }

template <typename Shape>
const Shape& shape(const Scene& scene, const std::string& name) {
  for (const Object& object : scene.objects) {
    if (object.name == name) return std::get<Shape>(object.shape);
  }
  throw std::out_of_range(name);
}

TEST(SceneReader, ReadsEveryValue) {
  const Scene scene = read(readYamlText(kSceneText, "scene"));
  EXPECT_EQ(scene.frame_id, "map");
  EXPECT_EQ(scene.rate, 200.0);
  ASSERT_EQ(scene.objects.size(), 4u);

  const Rope& rope = shape<Rope>(scene, "cable");
  EXPECT_EQ(rope.start, Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(rope.end, Eigen::Vector3d(1, 0, 1));
  EXPECT_EQ(rope.segments, 40);
  EXPECT_EQ(rope.mass, 0.2);
  EXPECT_EQ(rope.stiffness, 1e4);
  EXPECT_EQ(rope.axial_rigidity, std::nullopt);
  EXPECT_EQ(rope.bend_stiffness, 10.0);
  EXPECT_EQ(rope.damping, 0.1);

  const Cloth& cloth = shape<Cloth>(scene, "sheet");
  EXPECT_EQ(cloth.size, Eigen::Vector2d(1, 2));
  EXPECT_EQ(cloth.resolution, (std::array<int, 2>{20, 10}));
  EXPECT_EQ(cloth.position, Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(cloth.orientation, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(cloth.mass, 0.2);
  EXPECT_EQ(cloth.stiffness, 1000.0);
  EXPECT_EQ(cloth.shear_stiffness, 500.0);
  EXPECT_EQ(cloth.bend_stiffness, 100.0);
  EXPECT_EQ(cloth.damping, 0.1);

  const Lattice& lattice = shape<Lattice>(scene, "block");
  EXPECT_EQ(lattice.size, Eigen::Vector3d(0.3, 0.4, 0.5));
  EXPECT_EQ(lattice.resolution, (std::array<int, 3>{4, 3, 2}));
  EXPECT_EQ(lattice.mass, 1.0);  // an integer serves
  EXPECT_EQ(lattice.stiffness, 200.0);
  EXPECT_EQ(lattice.shear_stiffness, std::nullopt);

  const Particles& net = shape<Particles>(scene, "net");
  EXPECT_EQ(net.positions.at(2), Eigen::Vector3d(0.2, 0, 1));
  EXPECT_EQ(net.velocities.at(2), Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(net.masses, std::vector<double>(3, 0.01));
  EXPECT_EQ(net.springs.at(1), (std::array<std::uint32_t, 2>{1, 2}));
  EXPECT_EQ(net.stiffness, (std::vector<double>{100.0, 200.0}));
  EXPECT_EQ(net.damping, std::vector<double>(2, 0.1));
  EXPECT_EQ(net.rest_lengths, std::vector<double>(2, 0.1));

  ASSERT_EQ(scene.pins.size(), 2u);
  EXPECT_EQ(scene.pins[1].object, "sheet");
  EXPECT_EQ(scene.pins[1].particles, (std::vector<std::uint32_t>{0, 19}));
  ASSERT_TRUE(scene.effects.gravity);
  EXPECT_EQ(scene.effects.gravity->acceleration, Eigen::Vector3d(0, 0, -9.81));
  EXPECT_EQ(scene.timeline.size(), 4u);
}

TEST(SceneReader, TakesObjectsAndPinsInBytewiseOrder) {
  Tree tree = sceneWith("objects.Zebra", "{type: particles, positions: [[0, 0, 0]], masses: 1}");
  put(tree, "pins.Last", "{object: Zebra, particles: [0]}");
  const Scene scene = read(tree);
  Lines objects, pins;
  for (const Object& object : scene.objects) objects.push_back(object.name);
  for (const ScenePin& pin : scene.pins) pins.push_back(pin.name);
  EXPECT_EQ(objects, (Lines{"Zebra", "block", "cable", "net", "sheet"}));
  EXPECT_EQ(pins, (Lines{"Last", "gripper", "left"}));
}

TEST(SceneReader, LeavesDefaultsWhereNothingIsGiven) {
  const Scene scene = read(readYamlText(
      "objects: {a: {type: cloth, size: [1, 1], resolution: [2, 2], mass: 1, stiffness: 0}}\n"
      "solver:\npins:\neffects: {}\npublish: ~\n",
      "scene"));
  const Scene defaults;
  EXPECT_EQ(scene.frame_id, "world");
  EXPECT_EQ(scene.rate, 100.0);
  EXPECT_EQ(scene.real_time_factor, 1.0);
  EXPECT_FALSE(scene.start_paused);
  EXPECT_EQ(scene.solver.scheme, defaults.solver.scheme);
  EXPECT_EQ(scene.solver.newton_tolerance, 1e-6);
  EXPECT_EQ(scene.publish.state, 100.0);
  EXPECT_EQ(scene.limits.max_force, 1e6);
  EXPECT_EQ(scene.limits.max_speed, 1e3);
  EXPECT_EQ(scene.limits.max_extent, 1e6);
  EXPECT_FALSE(scene.effects.gravity);
  EXPECT_TRUE(scene.pins.empty());
  EXPECT_EQ(scene.objects[0].color, Object().color);
  EXPECT_EQ(shape<Cloth>(scene, "a").position, Eigen::Vector3d::Zero());
}

TEST(SceneReader, ReadsSolverPublishAndLimits) {
  Tree tree = sceneWith("solver",
                        "{scheme: linear_implicit_euler, substeps: 3, newton_tolerance: 1e-4,"
                        " max_newton_iterations: 7, linear_solver: cholesky,"
                        " linear_tolerance: 1.0e-8, max_linear_iterations: 9, budget: 0.005,"
                        " threads: 2}");
  put(tree, "publish", "{markers: 1, state: 0, stats: 3.5}");
  put(tree, "limits", "{max_force: 1e3, max_speed: 20, max_extent: 5.0}");
  put(tree, "start_paused", "yes");
  const Scene scene = read(tree);
  EXPECT_EQ(scene.solver.scheme, Scheme::kLinearImplicitEuler);
  EXPECT_EQ(scene.solver.substeps, 3);
  EXPECT_EQ(scene.solver.newton_tolerance, 1e-4);
  EXPECT_EQ(scene.solver.max_newton_iterations, 7);
  EXPECT_EQ(scene.solver.linear_solver, LinearSolver::kCholesky);
  EXPECT_EQ(scene.solver.linear_tolerance, 1e-8);
  EXPECT_EQ(scene.solver.max_linear_iterations, 9);
  EXPECT_EQ(scene.solver.budget, 0.005);
  EXPECT_FALSE(scene.solver.accuracy);
  EXPECT_EQ(scene.solver.threads, 2);
  EXPECT_EQ(scene.publish.markers, 1.0);
  EXPECT_EQ(scene.publish.state, 0.0);
  EXPECT_EQ(scene.publish.stats, 3.5);
  EXPECT_EQ(scene.limits.max_force, 1000.0);
  EXPECT_EQ(scene.limits.max_speed, 20.0);
  EXPECT_EQ(scene.limits.max_extent, 5.0);
  EXPECT_TRUE(scene.start_paused);
}

TEST(SceneReader, TakesWhatIsUnusualButRight) {
  for (const auto& [path, value] : std::vector<std::pair<std::string, std::string>>{
           {"rate", "1"},
           {"rate", "1e4"},      // a string under YAML 1.1
           {"rate", "'1.0e2'"},  // and in quotes
           {"rate", "0x10"},
           {"real_time_factor", "0"},
           {"objects.sheet.orientation", "[deg(90), rad(1.5), 0]"},
           {"objects.sheet.stiffness", "0"},
           {"objects.cable.end", "[0, 0, 1]"},  // springs of rest length 0
           {"objects.cable.stiffness", "0.0"},
           {"objects.cable.damping", "0"},
           {"objects.net.positions", "[[0, 0, 0], [0, 0, 0], [0, 0, 0]]"},
           {"objects.net.springs", "[[0, 1], [1, 0]]"},
           {"objects.net.rest_lengths", "0"},
           {"objects.net.velocities", kRemoved},
           {"objects.on", "{type: particles, positions: [[0, 0, 0]], masses: 1}"},
           {"pins.all", "{object: net, particles: [0, 1, 2]}"},
           {"effects", kRemoved},
           {"timeline", "[]"},
       }) {
    EXPECT_EQ(problemsOf(sceneWith(path, value)), Lines()) << path << ": " << value;
  }
}

TEST(SceneReader, TakesParticlesWithoutSprings) {
  EXPECT_EQ(problemsOf("objects: {a: {type: particles, positions: [[0, 0, 0]], masses: [2]}}"),
            Lines());
}

TEST(SceneReader, TakesAxialRigidityInsteadOfStiffness) {
  Tree tree = sceneWith("objects.cable.stiffness", kRemoved);
  put(tree, "objects.cable.axial_rigidity", "250");
  EXPECT_EQ(shape<Rope>(read(tree), "cable").axial_rigidity, 250.0);
  put(tree, "objects.cable.end", "[0, 0, 1]");
  EXPECT_EQ(problemsOf(tree),
            Lines{"objects.cable.axial_rigidity: got a rope without length, expected different "
                  "start and end, or stiffness instead"});
}

struct BadValue {
  const char *path, *value, *problem;
};

/// Each row: the scene with one value changed has this one problem.
TEST(SceneReader, RefusesEachBadValueByName) {
  const std::vector<BadValue> rows = {
      // The scene.
      {"frame_id", "''",
       "frame_id: got '', expected the name of a frame, without leading slash or blanks"},
      {"frame_id", "/map",
       "frame_id: got '/map', expected the name of a frame, without leading slash or blanks"},
      {"frame_id", "3",
       "frame_id: got 3, expected the name of a frame, without leading slash or blanks"},
      {"rate", "0.5", "rate: got 0.5, expected a number in [1, 10000] (Hz)"},
      {"rate", ".nan", "rate: got nan, expected a number in [1, 10000] (Hz)"},
      {"rate", "1e999", "rate: got '1e999', expected a number in [1, 10000] (Hz)"},
      {"rate", "fast", "rate: got 'fast', expected a number in [1, 10000] (Hz)"},
      {"rate", "yes", "rate: got true, expected a number in [1, 10000] (Hz)"},
      {"rate", "~", "rate: got nothing, expected a number in [1, 10000] (Hz)"},
      {"rate", "1:40", "rate: got '1:40', expected a number in [1, 10000] (Hz)"},
      {"rate", "rad(pi)", "rate: got 'rad(pi)', expected a number in [1, 10000] (Hz)"},
      {"real_time_factor", "101", "real_time_factor: got 101, expected a number in [0, 100]"},
      {"start_paused", "1", "start_paused: got 1, expected true or false"},
      {"start_paused", "'true'", "start_paused: got 'true', expected true or false"},
      // The solver.
      {"solver", "[]", "solver: got an empty list, expected a map of solver options"},
      {"solver.scheme", "implicit_eular",
       "solver.scheme: got 'implicit_eular', expected one of explicit_euler, symplectic_euler, "
       "rk4, linear_implicit_euler, implicit_euler, implicit_midpoint, bdf2, tr_bdf2, ros3, xpbd, "
       "auto "
       "(did "
       "you mean 'implicit_euler'?)"},
      {"solver.substeps", "0", "solver.substeps: got 0, expected an integer in [1, 100000]"},
      {"solver.substeps", "3.0",
       "solver.substeps: got 3.0, expected an integer in [1, 100000] without a dot"},
      {"solver.substeps", "10000000000000000000",
       "solver.substeps: got 1.0e+19, expected an integer in [1, 100000] without a dot"},
      {"solver.newton_tolerance", "1",
       "solver.newton_tolerance: got 1, expected a number in (0, 1)"},
      {"solver.max_newton_iterations", "1001",
       "solver.max_newton_iterations: got 1001, expected an integer in [1, 1000]"},
      {"solver.linear_solver", "multgrid",
       "solver.linear_solver: got 'multgrid', expected one of auto, conjugate_gradient, cholesky, "
       "banded, multigrid (did you mean 'multigrid'?)"},
      {"solver.linear_tolerance", "0.0",
       "solver.linear_tolerance: got 0.0, expected a number in (0, 1)"},
      {"solver.max_linear_iterations", "-1",
       "solver.max_linear_iterations: got -1, expected an integer in [1, 1000000]"},
      {"solver.accuracy", "0", "solver.accuracy: got 0, expected a number > 0 (m)"},
      {"solver", "{scheme: bdf2, accuracy: 0.001}",
       "solver.accuracy: got 0.001, expected a scheme with an estimate of its error: "
       "symplectic_euler, rk4, tr_bdf2, "
       "ros3 or auto"},
      {"solver", "{accuracy: 0.001, budget: 0.005}",
       "solver.budget: got 0.005, expected either accuracy or budget"},
      {"solver.threads", "257", "solver.threads: got 257, expected an integer in [0, 256]"},
      // Objects.
      {"objects.2nd", "{type: particles, positions: [[0, 0, 0]], masses: 1}",
       "objects.2nd: got the name '2nd', expected a name of letters, digits and _ that begins with "
       "a letter"},
      {"objects.cable.type", "rop",
       "objects.cable.type: got 'rop', expected one of rope, cloth, lattice, mesh, particles (did "
       "you mean 'rope'?)"},
      {"objects.cable.color", "[1, 0, 0]",
       "objects.cable.color: got a list of 3, expected a list of 4 numbers in [0, 1] (red green "
       "blue alpha)"},
      {"objects.cable.color", "[1, 0, 0, 2]",
       "objects.cable.color[3]: got 2, expected a number in [0, 1] (red green blue alpha)"},
      {"objects.cable.start", "0",
       "objects.cable.start: got 0, expected a list of 3 finite numbers (m)"},
      {"objects.cable.start", "[0, .inf, 0]",
       "objects.cable.start[1]: got inf, expected a finite number (m)"},
      {"objects.cable.segments", "0",
       "objects.cable.segments: got 0, expected an integer in [1, 1999999]"},
      {"objects.cable.mass", kRemoved,
       "objects.cable.mass: got nothing, expected a number > 0 (kg)"},
      {"objects.cable.stiffness", kRemoved,
       "objects.cable.stiffness: got nothing, expected a number >= 0 (N/m), or axial_rigidity "
       "instead"},
      {"objects.cable.axial_rigidity", "250",
       "objects.cable.axial_rigidity: got a stiffness as well, expected either stiffness or "
       "axial_rigidity"},
      {"objects.cable.bend_stiffness", "-1",
       "objects.cable.bend_stiffness: got -1, expected a number >= 0 (N/m)"},
      {"objects.cable.damping", "-1",
       "objects.cable.damping: got -1, expected a number >= 0 (N s/m)"},
      {"objects.sheet.size", "[1, 0]", "objects.sheet.size[1]: got 0, expected a number > 0 (m)"},
      {"objects.sheet.size", "[1, 1, 1]",
       "objects.sheet.size: got a list of 3, expected a list of 2 numbers > 0 (m)"},
      {"objects.sheet.mass", "-1", "objects.sheet.mass: got -1, expected a number > 0 (kg)"},
      {"objects.sheet.stiffness", "-1",
       "objects.sheet.stiffness: got -1, expected a number >= 0 (N/m)"},
      {"objects.sheet.resolution", "[20]",
       "objects.sheet.resolution: got a list of 1, expected a list of 2 integers >= 2"},
      {"objects.block.resolution", "[2, 2, 1]",
       "objects.block.resolution[2]: got 1, expected an integer in [2, 2000000]"},
      {"objects.block.resolution", "[1000000, 1000000, 2]",
       "objects.block.resolution: got 2000000000000 particles, expected at most 2000000 particles"},
      {"objects.net.positions", "[]",
       "objects.net.positions: got an empty list, expected at least one position"},
      {"objects.net.velocities", "[[0, 0, 0]]",
       "objects.net.velocities: got a list of 1, expected a list of 3, one for each particle"},
      {"objects.net.masses", "[1, 2]",
       "objects.net.masses: got a list of 2, expected a number > 0 (kg), or a list of 3 numbers > "
       "0 (kg)"},
      {"objects.net.masses", "[1, 2, 0]",
       "objects.net.masses[2]: got 0, expected a number > 0 (kg)"},
      {"objects.net.springs", "[[0, 3], [1, 2]]",
       "objects.net.springs[0][1]: got 3, expected an integer in [0, 2]"},
      {"objects.net.springs", "[[0, 1], [1, 1]]",
       "objects.net.springs[1]: got a spring from particle 1 to itself, expected a pair of "
       "different particle indices"},
      {"objects.net.springs", "[[0, 1], [0, 1, 2]]",
       "objects.net.springs[1]: got a list of 3, expected a pair of different particle indices"},
      {"objects.net.stiffness", kRemoved,
       "objects.net.stiffness: got nothing, expected a number >= 0 (N/m), or a list of 2 numbers "
       ">= 0 (N/m)"},
      {"objects.net.rest_lengths", "[0.1, -0.1]",
       "objects.net.rest_lengths[1]: got -0.1, expected a number >= 0 (m)"},
      {"objects.net.damping", "a",
       "objects.net.damping: got 'a', expected a number >= 0 (N s/m), or a list of 2 numbers >= 0 "
       "(N s/m)"},
      // Pins and effects.
      {"pins.left.object", "shet",
       "pins.left.object: got 'shet', expected one of block, cable, net, sheet (did you mean "
       "'sheet'?)"},
      {"pins.left.object", kRemoved,
       "pins.left.object: got nothing, expected one of block, cable, net, sheet"},
      {"pins.left.particles", "[]",
       "pins.left.particles: got an empty list, expected at least one particle index"},
      {"pins.left.particles", "[0, 200]",
       "pins.left.particles[1]: got 200, expected an integer in [0, 199]"},
      {"pins.left.particles", "[4, 7, 4]",
       "pins.left.particles[2]: got 4 again, expected each particle once"},
      {"pins.more", "{object: sheet, particles: [5, 19]}",
       "pins.more.particles[1]: got 19, expected a particle that no other pin holds ('left' holds "
       "it)"},
      {"pins.a b", "{object: net, particles: [0]}",
       "pins.a b: got the name 'a b', expected a name of letters, digits and _ that begins with a "
       "letter"},
      {"effects.gravity", "~",
       "effects.gravity.acceleration: got nothing, expected a list of 3 finite numbers (m/s^2)"},
      {"publish.state", "10001",
       "publish.state: got 10001, expected a number in [0, 10000] (Hz, 0 = never)"},
      {"limits.max_force", "0", "limits.max_force: got 0, expected a number > 0 (N)"},
      {"limits.max_speed", "0",
       "limits.max_speed: got 0, expected a number in [1.0e-06, 1.0e+09] (m/s)"},
      {"limits.max_extent", "1e10",
       "limits.max_extent: got 1.0e+10, expected a number in [1.0e-06, 1.0e+09] (m)"},
  };
  for (const BadValue& row : rows) {
    EXPECT_EQ(problemsOf(sceneWith(row.path, row.value)), Lines{row.problem})
        << row.path << ": " << row.value;
  }
}

// Single precision, in which markers and points are, holds no more than 3.4e38.
TEST(SceneReader, RefusesPlacesThatSinglePrecisionCannotHold) {
  const std::string too_far = ": got 1.0e+300 m, expected at most 1000000000.0 m";
  for (const char* path : {"objects.cable.start", "objects.cable.end", "objects.sheet.position",
                           "objects.block.position", "objects.net.positions[1]",
                           "timeline[1].pin.target", "timeline[2].pin.target"}) {
    EXPECT_EQ(problemsOf(sceneWith(path, "[0, -1e300, 0]")), Lines{path + too_far});
    EXPECT_TRUE(problemsOf(sceneWith(path, "[0, -1e9, 0]")).empty()) << path;
  }
  EXPECT_EQ(problemsOf(sceneWith("objects.sheet.size", "[1e300, 1]")),
            Lines{"objects.sheet.size" + too_far});
  EXPECT_EQ(
      problemsOf(sceneWith("objects.net.velocities", "[[1e300, 0, 0], [0, 0, 0], [0, 0, 0]]")),
      Lines{"objects.net.velocities[0]: got 1.0e+300 m/s, expected at most 1000000000.0 m/s"});
  for (const auto& [shape, key] :
       {std::pair("{type: plane, point: [1e300, 0, 0], normal: [0, 0, 1]}", "point"),
        std::pair("{type: sphere, center: [1e300, 0, 0], radius: 1}", "center"),
        std::pair("{type: sphere, center: [0, 0, 0], radius: 1e300}", "radius"),
        std::pair("{type: box, center: [1e300, 0, 0], size: [1, 1, 1]}", "center"),
        std::pair("{type: box, center: [0, 0, 0], size: [1, 1e300, 1]}", "size"),
        std::pair("{type: capsule, start: [1e300, 0, 0], end: [0, 0, 0], radius: 1}", "start"),
        std::pair("{type: capsule, start: [0, 0, 0], end: [1e300, 0, 0], radius: 1}", "end"),
        std::pair("{type: capsule, start: [0, 0, 0], end: [1, 0, 0], radius: 1e300}", "radius")}) {
    Tree tree = sceneWith("effects.contact", "{stiffness: 10}");
    put(tree, "effects.contact.shapes", std::string("{it: ") + shape + "}");
    EXPECT_EQ(problemsOf(tree), Lines{std::string("effects.contact.shapes.it.") + key + too_far});
  }
}

TEST(SceneReader, RefusesMeshesThatSinglePrecisionCannotHold) {
  const TemporaryFolder folder;
  folder.write("far.obj", "v 0 0 0\nv 1 0 0\nv 0 2e9 0\nf 1 2 3\n");
  const auto problems = [&](const std::string& scale) {
    try {
      readScene(readYamlText("objects: {skin: {type: mesh, file: far.obj, mass: 1, stiffness: 10" +
                                 scale + "}}",
                             "scene"),
                folder.path());
    } catch (const SceneError& error) {
      return error.problems();
    }
    return Lines();
  };
  EXPECT_EQ(problems(""), Lines{"objects.skin.file: got 2000000000.0 m from the origin of the "
                                "file, expected at most 1000000000.0 m from the origin of the "
                                "file"});
  EXPECT_EQ(problems(", scale: 2"), Lines{"objects.skin.scale: got 4000000000.0 m from the origin "
                                          "of the file, expected at most 1000000000.0 m from the "
                                          "origin of the file"});
  EXPECT_EQ(problems(", scale: 0.5"), Lines());
}

// ~state is published with each step, until that is more often than clients expect.
TEST(SceneReader, StatesArePublishedAtTheRateOfTheSceneByDefault) {
  for (const auto& [rate, expected] : {std::pair("60", 60.0), std::pair("250", 250.0),
                                       std::pair("1000", 1000.0), std::pair("4000", 1000.0)}) {
    Tree tree = sceneWith("rate", rate);
    EXPECT_EQ(read(tree).publish.state, expected) << rate;
    put(tree, "publish.markers", "5");
    EXPECT_EQ(read(tree).publish.state, expected) << rate;
    put(tree, "publish.state", "20");
    EXPECT_EQ(read(tree).publish.state, 20.0) << rate;
  }
}

/// Keys of other versions and slips of the pen alike.
TEST(SceneReader, RefusesUnknownKeysEverywhere) {
  for (const char* path :
       {"gravity", "solver.cores", "objects.cable.file", "objects.sheet.points",
        "objects.block.segments", "objects.net.size", "pins.left.frame", "effects.sun",
        "effects.gravity.strength", "timeline[0].command", "timeline[0].force.frame",
        "timeline[1].pin.forces", "timeline[3].pin.target", "publish.force", "limits.max_mass"}) {
    const Lines problems = problemsOf(sceneWith(path, "1"));
    ASSERT_EQ(problems.size(), 1u) << path;
    EXPECT_EQ(problems[0].find(path + std::string(": got an unknown key, expected one of ")), 0u)
        << problems[0];
  }
}

TEST(SceneReader, NamesTheNearestKnownKey) {
  EXPECT_EQ(problemsOf(sceneWith("publish.stat", "1")),
            Lines{"publish.stat: got an unknown key, expected one of markers, state, "
                  "points, pins, contacts, stats (did you mean 'state'?)"});
  EXPECT_EQ(problemsOf(sceneWith("limits.velocity", "1")),
            Lines{"limits.velocity: got an unknown key, expected one of max_force, max_speed, "
                  "max_extent"});
}

TEST(SceneReader, CollectsEveryProblem) {
  Tree tree = sceneWith("rate", "-1");
  put(tree, "solver.shceme", "rk4");
  put(tree, "objects.cable.mass", "0");
  put(tree, "objects.cable.start", "[a, 0, .nan]");
  put(tree, "objects.sheet.type", "clot");
  put(tree, "objects.net.springs", "[[0, 0], [0, 9]]");
  put(tree, "pins.left.object", "nobody");
  put(tree, "effects.gravity.acceleration", "9.81");
  put(tree, "timeline[0].force.duration", "long");
  Lines paths;
  for (const std::string& line : problemsOf(tree)) paths.push_back(line.substr(0, line.find(':')));
  EXPECT_EQ(paths, (Lines{"rate", "solver.shceme", "objects.cable.start[0]",
                          "objects.cable.start[2]", "objects.cable.mass", "objects.net.springs[0]",
                          "objects.net.springs[1][1]", "objects.sheet.type", "pins.left.object",
                          "effects.gravity.acceleration", "timeline[0].force.duration"}));
}

TEST(SceneReader, RefusesScenesWithoutObjects) {
  const Lines expected = {"objects: got nothing, expected a map of at least one object"};
  EXPECT_EQ(problemsOf(""), expected);
  EXPECT_EQ(problemsOf("rate: 100"), expected);
  EXPECT_EQ(problemsOf("objects:"), expected);
  EXPECT_EQ(problemsOf("objects: {}"),
            Lines{"objects: got an empty map, expected a map of at least one object"});
  EXPECT_EQ(problemsOf("[1, 2]"), Lines{"scene: got a list of 2, expected a map with objects"});
  EXPECT_EQ(problemsOf("hello"), Lines{"scene: got 'hello', expected a map with objects"});
}

TEST(SceneReader, RefusesMoreParticlesThanMemoryHolds) {
  EXPECT_EQ(problemsOf(sceneWith("objects.sheet.resolution", "[1000000, 1000000]")),
            Lines{"objects.sheet.resolution: got 1000000000000 particles, expected at most 2000000 "
                  "particles"});
  Tree tree = sceneWith("objects.sheet.resolution", "[1000, 1000]");
  put(tree, "objects.cable.segments", "1999999");
  EXPECT_EQ(problemsOf(tree),  // 24 of the block, 3 of the net
            Lines{"objects: got 3000027 particles, expected at most 2000000 particles"});
}

TEST(SceneReader, StopsListingProblemsAtSomePoint) {
  std::string text = "objects:\n";
  for (int i = 0; i < 3000; ++i) text += "  o" + std::to_string(i) + ": {}\n";
  const Lines problems = problemsOf(text);
  EXPECT_EQ(problems.size(), 1001u);
  EXPECT_EQ(problems.back(), "scene: got 3000 problems, expected none");
}

}  // namespace
}  // namespace mass_spring
