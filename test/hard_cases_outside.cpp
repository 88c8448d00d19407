#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "hard_cases_checks.h"
#include "mass_spring_sim/measures.h"
#include "scene_text.h"

// Bad input, and what is done to a scene from outside.
namespace mass_spring {
namespace {

PinCommand moveTo(const std::string& name, const Eigen::Vector3d& position) {
  PinCommand move;
  move.action = PinCommand::Action::kMove;
  move.name = name;
  move.target.position = position;
  return move;
}

/// The total momentarily; a reference for what may be gained later.
double totalEnergy(Watched& run) { return energy(run->model(), run->state()).total(); }

}  // namespace

void billionNewtons(Trial& trial) {
  Scene scene = sceneOf(trial, sheet(trial, 5));
  pin(scene, {0});
  ForceCommand push;
  push.particles = {12};
  push.forces = {Eigen::Vector3d(0, 6e8, 8e8)};
  {
    Watched limited(trial, scene);
    EXPECT_EQ(limited->apply(push).refusal, Refusal::kLimit);
  }
  scene.limits = {1e10, 1e9, 1e9};
  Watched run(trial, scene);
  ASSERT_TRUE(run->apply(push).accepted());
  const Eigen::Vector3d before = run->state().positions.col(12);
  run.step();
  if (run.failed()) return;
  const double work = push.forces[0].dot(run->state().positions.col(12) - before);
  if (solvesSprings(trial.scheme)) {
    EXPECT_LE(totalEnergy(run), work * (1.0 + 1e-6));
  }
  run.boundEnergy();
  run.step(10);
}

void pinTeleported(Trial& trial) {
  Particles net = sheet(trial, 4);
  for (double& c : *net.damping) c *= 10.0;  // some 1/20 of critical becomes half
  Scene scene = sceneOf(trial, net);
  addGravity(scene);
  pin(scene, {0, 3});
  Watched run(trial, scene);
  run.step(5);
  const Eigen::Vector3d hold = run->pins().all().at("hold").target.position;
  ASSERT_TRUE(run->apply(moveTo("hold", hold + Eigen::Vector3d(0.6, 0.8, 0))).accepted());
  run.step();
  if (run.failed()) return;
  run.boundEnergy();
  run.step(std::max(1, static_cast<int>(std::lround(1.0 / trial.h))));
  // The teleport stretches to 1.6 where the steps are short and the springs soft; an untouched
  // sheet swings with up to 1.007.
  if (solvesSprings(trial.scheme)) {
    EXPECT_LT(maxStretch(run->model(), run->state()), 1.05);
  }
}

void rotatedScene(Trial& trial) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(1.0, Eigen::Vector3d(1, 2, 3).normalized()));
  const auto scene = [&](const Eigen::Quaterniond& rotation) {
    Particles net = sheet(trial, 6);
    for (std::size_t i = 0; i < net.positions.size(); ++i) {
      net.velocities[i] = rotation * Eigen::Vector3d(0.3, 0.0, net.positions[i].x());
      net.positions[i] = rotation * net.positions[i];
    }
    Scene built = sceneOf(trial, net);
    built.effects.gravity = GravityOptions{rotation * Eigen::Vector3d(0, 0, -9.81)};
    pin(built, {0, 5});
    // What Newton leaves must lie below what is compared: at the default 1e-6 the two answers
    // differ by what the solvers leave, some 1e-10 m.
    built.solver.newton_tolerance = 1e-10;
    return built;
  };
  Watched straight(trial, scene(Eigen::Quaterniond::Identity())), turned(trial, scene(turn));
  straight.step(5);
  turned.step(5);
  if (straight.failed() || turned.failed()) return;
  const Vectors expected = turn.toRotationMatrix() * straight->state().positions;
  EXPECT_LT((turned->state().positions - expected).cwiseAbs().maxCoeff(), 1e-10);
}

void badValuesRefused(Trial& /*trial*/) {
  struct Bad {
    const char *path, *value;
  };
  for (const Bad& bad : std::initializer_list<Bad>{{"objects.net.stiffness", "-1.0"},
                                                   {"objects.net.stiffness", ".nan"},
                                                   {"objects.net.damping", "-0.1"},
                                                   {"objects.net.masses", "0.0"},
                                                   {"objects.net.masses", "-0.01"},
                                                   {"objects.net.masses", ".nan"},
                                                   {"objects.net.positions[1][2]", ".nan"},
                                                   {"objects.net.velocities[0][0]", ".inf"},
                                                   {"objects.net.rest_lengths", "-0.1"},
                                                   {"objects.cable.mass", "0"},
                                                   {"objects.sheet.stiffness", "-5.0"},
                                                   {"rate", "0.0"},
                                                   {"rate", "-100.0"},
                                                   {"rate", ".inf"},
                                                   {"effects.gravity.acceleration[2]", ".nan"}}) {
    const std::vector<std::string> problems = problemsOf(sceneWith(bad.path, bad.value));
    ASSERT_EQ(problems.size(), 1u) << bad.path << ": " << bad.value;
    EXPECT_EQ(problems[0].find(bad.path), 0u) << problems[0];
  }
}

// The same in millimeters, grams and milliseconds: with m -> 1e3, kg -> 1e3, s -> 1e3, a stiffness
// kg/s^2 -> 1e-3, a damping kg/s -> 1, an acceleration m/s^2 -> 1e-3.
void otherUnits(Trial& trial) {
  const auto scene = [&](double unit) {
    Particles net = sheet(trial, 6);
    for (auto& x : net.positions) x *= unit;
    for (double& m : net.masses) m *= unit;
    for (double& k : net.stiffness) k /= unit;
    for (double& l : *net.rest_lengths) l *= unit;
    Scene built = sceneOf(trial, net);
    built.rate /= unit;
    built.effects.gravity = GravityOptions{Eigen::Vector3d(0, 0, -9.81 / unit)};
    pin(built, {0, 5});
    return built;
  };
  Watched meters(trial, scene(1.0)), millimeters(trial, scene(1e3));
  meters.step(10);
  millimeters.step(10);
  if (meters.failed() || millimeters.failed()) return;
  EXPECT_LT((millimeters->state().positions / 1e3 - meters->state().positions).norm(), 1e-9);
  EXPECT_EQ(meters->totals().newton_iterations, millimeters->totals().newton_iterations);
  EXPECT_EQ(meters->totals().unconverged_steps, millimeters->totals().unconverged_steps);
}

// Two jaws hold opposite faces of a block and close until they touch.
void gripperSqueezesShut(Trial& trial) {
  Scene scene = sceneOf(trial, block(trial, 3));
  ScenePin left{"left", "net", {}}, right{"right", "net", {}};
  for (std::uint32_t row = 0; row < 9; ++row) {
    left.particles.push_back(3 * row);
    right.particles.push_back(3 * row + 2);
  }
  scene.pins = {left, right};
  Watched run(trial, scene);
  const auto& pins = run->pins().all();
  const Eigen::Vector3d from_left = pins.at("left").target.position,
                        from_right = pins.at("right").target.position;
  const Eigen::Vector3d middle = 0.5 * (from_left + from_right);
  const int closing = 10;
  for (int n = 1; n <= closing && !run.failed(); ++n) {
    const double share = static_cast<double>(n) / closing;
    run->apply(moveTo("left", from_left + share * (middle - from_left)));
    run->apply(moveTo("right", from_right + share * (middle - from_right)));
    run.step();
  }
  if (run.failed()) return;
  // The midpoint rule keeps what is squeezed ringing; its energy comes and goes by some 1e-3.
  run.boundEnergy(dampsWhatIsStiff(trial.scheme) ? 2e-4 : 1e-2);
  run.step(10);
  double strongest = 0.0, bound = 0.0;
  for (const Spring& s : run->model().springs) {
    strongest = std::max(strongest,
                         s.stiffness * s.rest_length * std::abs(strain(s, run->state().positions)));
    bound = std::max(bound, s.stiffness * s.rest_length);
  }
  // The block slips out between the jaws, and is hardly strained any more once it rests.
  EXPECT_LT(strongest, (dampsWhatIsStiff(trial.scheme) ? 0.1 : 1.0) * bound);
}

}  // namespace mass_spring
