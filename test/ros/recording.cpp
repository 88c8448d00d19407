#include "recording.h"

#include <rosbag/bag.h>
#include <std_msgs/String.h>
#include <stdlib.h>

#include <filesystem>
#include <stdexcept>
#include <utility>

#include "mass_spring_sim/scene_reader.h"
#include "ros/conversions.h"

namespace mass_spring {

using mass_spring_sim::AppliedCommand;

const char* const kRecordedScene = R"(
rate: 100.0
solver: {scheme: implicit_euler, threads: 1}
objects:
  sheet: {type: cloth, size: [0.4, 0.3], resolution: [5, 4], position: [0.0, 0.0, 1.0], mass: 0.2,
          stiffness: 500.0, shear_stiffness: 200.0, damping: 0.1}
  cable: {type: rope, start: [0.0, 1.0, 1.0], end: [1.0, 1.0, 1.0], segments: 6, mass: 0.1,
          stiffness: 1000.0}
pins:
  corner: {object: sheet, particles: [0]}
  end: {object: cable, particles: [0], follow_frame: hand}
effects:
  gravity: {acceleration: [0.0, 0.0, -9.81]}
  contact:
    stiffness: 1000.0
    shapes: {ball: {type: sphere, center: [0.0, 0.0, 0.85], radius: 0.1}}
timeline:
  - {time: 0.043, force: {object: cable, particles: [3], forces: [[0.0, 0.0, 1.0]], duration: 0.05}}
)";

Recording::Recording(const std::string& scene, Stamps stamps) : stamps_(stamps) {
  take(scene);
  this->scene = toYaml(simulation_->scene());
}

void Recording::apply(const Command& command, const std::string& sender) {
  const CommandResult result = simulation_->apply(command);
  if (!result.accepted()) throw std::runtime_error(result.message);
  tell(toMessage(command), sender);
}

void Recording::step(int steps) {
  for (int k = 0; k < steps; ++k) {
    const std::uint64_t number = simulation_->state().step + 1;
    if (simulation_->step().status == StepStatus::kFailed) {
      start_ = now_ - ros::Duration(simulation_->state().time);
      AppliedCommand message;
      message.kind = AppliedCommand::FAILED_STEP;
      message.step = number;
      tell(std::move(message), "");
      return;
    }
    now_ = stamps_ == Stamps::kWall ? now_ + ros::Duration(0, 1000)
                                    : start_ + ros::Duration(simulation_->state().time);
    tellState();
  }
}

void Recording::reset() {
  simulation_->reset();
  startOver();
  tell(AppliedCommand::RESET);
  tellState();
}

void Recording::reload(const std::string& scene) {
  const std::unique_ptr<Simulation> old = std::move(simulation_);
  take(scene);
  const bool continued = simulation_->continueFrom(*old);
  if (!continued) startOver();
  AppliedCommand message;
  message.kind = AppliedCommand::RELOAD;
  message.scene = toYaml(simulation_->scene());
  tell(std::move(message), "/somebody");
  if (!continued) tellState();
}

void Recording::setState(const Vectors& positions, const Vectors& velocities) {
  simulation_->setState(positions, velocities);
  AppliedCommand message;
  message.kind = AppliedCommand::SET_STATE;
  message.state = toMessage(simulation_->state());
  tell(std::move(message), "/somebody");
}

void Told::write(const std::string& file, const std::string& node) const {
  const bool exists = std::filesystem::exists(file);
  rosbag::Bag bag(file, exists ? rosbag::bagmode::Append : rosbag::bagmode::Write);
  std_msgs::String text;
  text.data = scene;
  bag.write(node + "/scene", ros::Time(1, 0), text);
  // As they came; of each topic in order, as far as the clock can tell.
  for (const auto& state : states) bag.write(node + "/state", state.header.stamp, state);
  for (const auto& command : commands) {
    bag.write(node + "/applied", command.header.stamp, command);
  }
}

void Recording::take(const std::string& scene) {
  simulation_ = std::make_unique<Simulation>(readScene(readYamlText(scene, "scene"), ""));
  simulation_->observeTimeline([this](const Command& command, const CommandResult& result) {
    if (result.accepted()) tell(toMessage(command), "timeline");
  });
}

void Recording::tell(AppliedCommand message, const std::string& sender) {
  if (stamps_ == Stamps::kWall && message.kind != AppliedCommand::RESET) {
    now_ += ros::Duration(0, 1000);
  }
  message.header.stamp = now_;
  message.number = commands.size() + 1;
  if (message.step == 0) message.step = simulation_->state().step + 1;
  message.sender = sender;
  commands.push_back(std::move(message));
}

void Recording::tell(std::uint8_t kind) {
  AppliedCommand message;
  message.kind = kind;
  tell(std::move(message), "/somebody");
}

void Recording::tellState() {
  states.push_back(toMessage(simulation_->state()));
  states.back().header.stamp = now_;
  states.back().commands = commands.size();
}

void Recording::startOver() {
  if (stamps_ == Stamps::kWall) now_ += ros::Duration(0, 1000);
  start_ = now_;
}

Folder::Folder() {
  std::string name = std::filesystem::temp_directory_path() / "recording_XXXXXX";
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no folder " + name);
  path_ = name;
}

Folder::~Folder() {
  std::error_code error;
  std::filesystem::remove_all(path_, error);
}

}  // namespace mass_spring
