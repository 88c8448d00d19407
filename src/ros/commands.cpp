#include "commands.h"

#include <mass_spring_sim/AppliedCommand.h>

#include <utility>

#include "topics.h"

namespace mass_spring {

namespace {

// roscpp drops the oldest message of a full queue without a word. Its queue is therefore without
// bound, and that of the loop refuses what is too much.
constexpr std::uint32_t kUnbounded = 0;

mass_spring_sim::AppliedCommand received(const mass_spring_sim::ForceCommand& message) {
  mass_spring_sim::AppliedCommand applied;
  applied.kind = mass_spring_sim::AppliedCommand::FORCE;
  applied.force = message;
  return applied;
}

mass_spring_sim::AppliedCommand received(const mass_spring_sim::PinCommand& message) {
  mass_spring_sim::AppliedCommand applied;
  applied.kind = mass_spring_sim::AppliedCommand::PIN;
  applied.pin = message;
  return applied;
}

mass_spring_sim::AppliedCommand received(const mass_spring_sim::ShapeCommand& message) {
  mass_spring_sim::AppliedCommand applied;
  applied.kind = mass_spring_sim::AppliedCommand::SHAPE;
  applied.shape = message;
  return applied;
}

}  // namespace

Commands::Commands(ros::NodeHandle nh, const Frames& frames, PhysicsLoop& loop,
                   Publishers& publishers)
    : frames_(frames),
      loop_(loop),
      publishers_(publishers),
      force_(nh.subscribe(topics::kForce, kUnbounded, &Commands::onForce, this)),
      pin_(nh.subscribe(topics::kPin, kUnbounded, &Commands::onPin, this)),
      shape_(nh.subscribe(topics::kShape, kUnbounded, &Commands::onShape, this)) {}

void Commands::onForce(const ros::MessageEvent<const mass_spring_sim::ForceCommand>& event) {
  receive<ForceCommand>(event, force_.getTopic());
}

void Commands::onPin(const ros::MessageEvent<const mass_spring_sim::PinCommand>& event) {
  receive<PinCommand>(event, pin_.getTopic());
}

void Commands::onShape(const ros::MessageEvent<const mass_spring_sim::ShapeCommand>& event) {
  receive<ShapeCommand>(event, shape_.getTopic());
}

template <class CoreCommand, class Message>
void Commands::receive(const ros::MessageEvent<const Message>& event, const std::string& topic) {
  const auto message = event.getMessage();
  const std::string sender = event.getPublisherName();
  CoreCommand command;
  const CommandResult translated = toCommand(
      *message, [this](const std::string& frame_id) { return frames_.find(frame_id).pose; },
      command);
  if (!translated.accepted()) {
    publishers_.rejected(topic, sender, translated);
    return;
  }
  const auto answer = [this, topic, sender, message](const CommandResult& result,
                                                     std::uint64_t step) {
    if (!result.accepted()) {
      publishers_.rejected(topic, sender, result);
      return;
    }
    mass_spring_sim::AppliedCommand applied = received(*message);
    applied.sender = sender;
    applied.step = step;
    publishers_.applied(std::move(applied));
  };
  if (!loop_.offer(std::move(command), answer)) {
    publishers_.rejected(topic, sender,
                         {Refusal::kLimit, "more than " + std::to_string(CommandQueue::kCapacity) +
                                               " commands wait for the next step"});
  }
}

}  // namespace mass_spring
