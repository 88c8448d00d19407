#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace mass_spring {

struct Pose {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();               ///< m
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  ///< of unit length
};

/// Forces on particles of one object, from the next step on. All vectors are in the scene's frame.
struct ForceCommand {
  std::string id;      ///< replaces the running command of the same id; "" = replaces none
  std::string object;  ///< "" only where the scene has exactly one object
  std::vector<std::uint32_t> particles;  ///< of that object; empty = all of them
  std::vector<Eigen::Vector3d> forces;   ///< N per particle; one for each, or one for all
  double duration = 0.0;  ///< s; > 0 rounded up to whole steps, 0 = one step, < 0 = until cleared
};

/// Makes, moves or removes a pin, from the next step on. Point and target are in the scene's frame.
struct PinCommand {
  enum class Action : std::uint8_t { kAdd = 0, kMove = 1, kRemove = 2 };
  Action action = Action::kAdd;
  std::string name;
  std::string object;                    ///< "" only where the scene has exactly one object
  std::vector<std::uint32_t> particles;  ///< explicit, or empty and:
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< m; the particles within radius of it
  double radius = 0.0;                              ///< m; 0 = the nearest one
  Pose target;        ///< where the pin is to go; on kAdd the particles keep their offsets to it
  bool here = false;  ///< kAdd: the pin's pose is the centroid of its particles; target is ignored
  std::string follow_frame;  ///< tf frame that leads the pin, "" = none; kMove: as in kAdd
};

/// Moves a shape of contact evenly from where it is to a target in the scene's frame, from the next
/// step on.
struct ShapeCommand {
  std::string name;
  Pose target;            ///< of its origin: its center, a plane's point, the middle of a capsule
  double duration = 0.0;  ///< s, >= 0, until the target; less than a step = one step
};

/// Removes all forces, or all pins, also the pins of the scene.
struct ClearCommand {
  enum class What : std::uint8_t { kForces = 0, kPins = 1 };
  What what = What::kForces;
};

using Command = std::variant<ForceCommand, PinCommand, ShapeCommand, ClearCommand>;

/// Why a command was refused; values as in RejectedCommand.msg.
enum class Refusal : std::uint8_t {
  kNone = 0,
  kNotFinite = 1,
  kUnknownObject = 2,
  kBadIndex = 3,
  kBadLength = 4,
  kBadFrame = 5,
  kUnknownPin = 6,
  kLimit = 7,
  kConflict = 8,
  kBadValue = 9,
  kUnknownShape = 10,
};

/// A command is applied as a whole or refused as a whole.
struct CommandResult {
  Refusal refusal = Refusal::kNone;
  std::string message;  ///< names the value and its place; empty if accepted
  bool accepted() const { return refusal == Refusal::kNone; }
};

}  // namespace mass_spring
