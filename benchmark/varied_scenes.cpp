#include "varied_scenes.h"

#include <cmath>
#include <random>

#include "mass_spring_sim/scene_reader.h"

namespace mass_spring {
namespace {

const EffectOptions kGravity = [] {
  EffectOptions effects;
  effects.gravity = GravityOptions{Eigen::Vector3d(0.0, 0.0, -9.81)};
  return effects;
}();

template <typename Shape>
Scene sceneOf(const Shape& shape, std::vector<std::uint32_t> pinned) {
  Scene scene;
  scene.rate = 60.0;
  scene.effects = kGravity;
  Object object;
  object.name = "body";
  object.shape = shape;
  scene.objects.push_back(object);
  if (!pinned.empty()) scene.pins.push_back({"pin", "body", std::move(pinned)});
  return scene;
}

/// All stiffnesses of the first object, which is not a rope by its axial rigidity.
Scene stiffer(Scene scene, double factor) {
  std::visit(
      [factor](auto& shape) {
        if constexpr (std::is_same_v<std::decay_t<decltype(shape)>, Particles>) {
          for (double& k : shape.stiffness) k *= factor;
        } else {
          if constexpr (std::is_same_v<std::decay_t<decltype(shape)>, Rope>) {
            *shape.stiffness *= factor;
          } else {
            shape.stiffness *= factor;
          }
          if constexpr (std::is_same_v<std::decay_t<decltype(shape)>, Cloth> ||
                        std::is_same_v<std::decay_t<decltype(shape)>, Lattice>) {
            if (shape.shear_stiffness) *shape.shear_stiffness *= factor;
          }
          if (shape.bend_stiffness) *shape.bend_stiffness *= factor;
        }
      },
      scene.objects[0].shape);
  return scene;
}

/// A chain of `links` springs of 1 m in all, level at the start, held at one end.
Particles chain(int links, double stiffness, double damping, double load) {
  Particles chain;
  for (int i = 0; i <= links; ++i) {
    chain.positions.emplace_back(static_cast<double>(i) / links, 0.0, 0.0);
    chain.masses.push_back(0.2 / links);
    if (i == 0) continue;
    const auto end = static_cast<std::uint32_t>(i);
    chain.springs.push_back({end - 1, end});
  }
  chain.masses.back() += load;
  chain.velocities.assign(chain.positions.size(), Eigen::Vector3d::Zero());
  chain.stiffness.assign(chain.springs.size(), stiffness);
  if (damping > 0.0) chain.damping.emplace(chain.springs.size(), damping);
  return chain;
}

Cloth cloth(int n, double stiffness, double damping) {
  Cloth cloth;
  cloth.size = {1.0, 1.0};
  cloth.resolution = {n, n};
  cloth.mass = 0.2;
  cloth.stiffness = stiffness;
  cloth.shear_stiffness = 0.5 * stiffness;
  cloth.bend_stiffness = 0.1 * stiffness;
  if (damping > 0.0) cloth.damping = damping;
  return cloth;
}

Lattice lattice(int n, double stiffness, double damping) {
  Lattice lattice;
  lattice.size = {0.3, 0.3, 0.3};
  lattice.resolution = {n, n, n};
  lattice.mass = 1.0;
  lattice.stiffness = stiffness;
  lattice.shear_stiffness = 0.3 * stiffness;
  if (damping > 0.0) lattice.damping = damping;
  return lattice;
}

/// A random spanning tree over particles in a box of 1 m, and as many springs again.
Particles net(int n, double stiffness, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Particles net;
  for (int i = 0; i < n; ++i) {
    const double x = unit(random), y = unit(random), z = unit(random);
    net.positions.emplace_back(x, y, z);
    net.velocities.emplace_back(0.0, 0.0, 0.0);
    net.masses.push_back(0.01 + 0.02 * unit(random));
  }
  const auto join = [&](int i, int j) {
    if (i != j)
      net.springs.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j)});
  };
  for (int i = 1; i < n; ++i) join(i, static_cast<int>(unit(random) * i));
  for (int k = 0; k < n; ++k) {
    const int i = static_cast<int>(unit(random) * n);
    join(i, static_cast<int>(unit(random) * n));
  }
  net.stiffness.assign(net.springs.size(), stiffness);
  net.damping.emplace(net.springs.size(), 0.02);
  return net;
}

/// A ring of 1 m across that turns in its plane.
Particles ring(int n, double stiffness, double speed) {
  Particles ring;
  for (int i = 0; i < n; ++i) {
    const double angle = 2.0 * M_PI * i / n;
    const Eigen::Vector3d out(std::cos(angle), std::sin(angle), 0.0);
    ring.positions.push_back(0.5 * out);
    ring.velocities.push_back(speed * Eigen::Vector3d(-out.y(), out.x(), 0.0));
    ring.masses.push_back(0.2 / n);
    ring.springs.push_back(
        {static_cast<std::uint32_t>(i), static_cast<std::uint32_t>((i + 1) % n)});
  }
  ring.stiffness.assign(ring.springs.size(), stiffness);
  return ring;
}

/// Takes the pin along at `velocity` [m/s] from 0.1 s on.
Scene movingPin(Scene scene, const Eigen::Vector3d& from, const Eigen::Vector3d& velocity,
                double duration) {
  for (int frame = 6; frame < duration * scene.rate; ++frame) {
    PinCommand move;
    move.action = PinCommand::Action::kMove;
    move.name = "pin";
    move.target.position = from + (frame - 5) / scene.rate * velocity;
    scene.timeline.push_back({frame / scene.rate, move});
  }
  return scene;
}

Scene struck(Scene scene, std::uint32_t particle, const Eigen::Vector3d& force) {
  ForceCommand strike;
  strike.particles = {particle};
  strike.forces = {force};
  strike.duration = 0.05;
  scene.timeline.push_back({0.2, strike});
  return scene;
}

}  // namespace

std::vector<VariedScene> variedScenes() {
  std::vector<VariedScene> scenes;
  const auto shipped = [&](const std::string& name, double duration) {
    scenes.push_back(
        {name + ".yaml",
         readSceneFile(MASS_SPRING_BENCHMARK_DIR "/../config/scenes/" + name + ".yaml"), duration});
  };
  const auto both = [&](const std::string& name, const Scene& scene, double duration) {
    scenes.push_back({name, scene, duration});
    scenes.push_back({name + ", k x 1000", stiffer(scene, 1e3), duration});
  };
  shipped("pendulum", 1.0);
  shipped("rope", 1.4);
  shipped("cloth", 0.5);
  shipped("lattice", 0.5);
  shipped("two_objects", 0.5);
  shipped("bunny", 0.3);

  both("pendulum of one link", sceneOf(chain(1, 1e3, 0.0, 1.0), {0}), 1.0);
  both("chain, undamped", sceneOf(chain(20, 1e3, 0.0, 0.0), {0}), 0.7);
  both("loaded rope", sceneOf(chain(20, 1e4, 0.5, 5.0), {0}), 1.0);
  both("cloth 8 x 8", sceneOf(cloth(8, 1e3, 0.1), {0, 7}), 0.7);
  both("cloth 12 x 12, undamped", sceneOf(cloth(12, 1e3, 0.0), {0}), 0.7);
  both("cloth 20 x 20", sceneOf(cloth(20, 1e3, 0.1), {0, 19}), 0.7);
  both("lattice 4 x 4 x 4", sceneOf(lattice(4, 1e3, 0.2), {63}), 0.7);
  both("random net", sceneOf(net(20, 300.0, 4), {0, 1}), 0.7);
  Scene turning = sceneOf(ring(24, 500.0, 3.0), {});
  turning.effects = EffectOptions();
  both("turning ring", turning, 0.7);
  both("cloth 10 x 10 led by a pin",
       movingPin(sceneOf(cloth(10, 500.0, 0.2), {0}), Eigen::Vector3d(-0.5, -0.5, 0.0),
                 Eigen::Vector3d(0.5, 0.3, 0.8), 0.7),
       0.7);
  both("struck chain",
       struck(sceneOf(chain(12, 2e3, 0.2, 0.05), {0, 12}), 6, Eigen::Vector3d(0.0, 3.0, 2.0)), 0.7);
  for (VariedScene& varied : scenes) {
    SolverOptions options;
    options.threads = 1;
    varied.scene.solver = options;
  }
  return scenes;
}

}  // namespace mass_spring
