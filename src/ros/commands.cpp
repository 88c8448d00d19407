#include "commands.h"

#include <ros/callback_queue.h>

#include <boost/make_shared.hpp>
#include <functional>
#include <utility>

#include "topics.h"

namespace mass_spring {

namespace {

// roscpp drops the oldest message of a full queue without a word. Its queue is therefore without
// bound, and that of the loop refuses what is too much.
constexpr std::uint32_t kUnbounded = 0;

// Small messages are not held back until there are more of them.
const ros::TransportHints kAtOnce = ros::TransportHints().tcpNoDelay();

/// Work for the thread of a queue.
class Job : public ros::CallbackInterface {
 public:
  explicit Job(std::function<void()> work) : work_(std::move(work)) {}
  CallResult call() override {
    work_();
    return Success;
  }

 private:
  std::function<void()> work_;
};

}  // namespace

Commands::Commands(ros::NodeHandle nh, ros::NodeHandle target_nh, const Frames& frames,
                   PhysicsLoop& loop, Publishers& publishers)
    : nh_(std::move(nh)),
      target_nh_(std::move(target_nh)),
      frames_(frames),
      loop_(loop),
      publishers_(publishers),
      force_(subscribe<ForceCommand, mass_spring_sim::ForceCommand>(topics::kForce)),
      pin_(subscribe<PinCommand, mass_spring_sim::PinCommand>(topics::kPin)),
      shape_(subscribe<ShapeCommand, mass_spring_sim::ShapeCommand>(topics::kShape)) {
  loop_.observeNames([this](Names names) {
    target_nh_.getCallbackQueue()->addCallback(
        boost::make_shared<Job>([this, names = std::move(names)] {
          listenTo(names.pins);
          publishers_.offerWrenches(names);
        }));
  });
}

template <class CoreCommand, class Message>
ros::Subscriber Commands::subscribe(const char* topic) {
  const boost::function<void(const ros::MessageEvent<const Message>&)> take =
      [this, name = nh_.resolveName(topic)](const ros::MessageEvent<const Message>& event) {
        receive<CoreCommand>(
            event, name,
            [](const Message& message, const FrameLookup& lookup, CoreCommand& command) {
              return toCommand(message, lookup, command);
            });
      };
  return nh_.subscribe<Message>(topic, kUnbounded, take, {}, kAtOnce);
}

void Commands::listenTo(const std::vector<std::string>& pins) {
  std::map<std::string, ros::Subscriber> targets;
  for (const std::string& pin : pins) {
    const auto known = targets_.find(pin);
    if (known != targets_.end()) {
      targets.emplace(*known);
      continue;
    }
    using Message = geometry_msgs::PoseStamped;
    const std::string topic = target_nh_.resolveName(topics::target(pin));
    const boost::function<void(const ros::MessageEvent<const Message>&)> take =
        [this, pin, topic](const ros::MessageEvent<const Message>& event) {
          receive<PinCommand>(
              event, topic,
              [&pin](const Message& message, const FrameLookup& lookup, PinCommand& command) {
                return toCommand(message, pin, lookup, command);
              });
        };
    // A handle remembers all that it has ever subscribed to: this one does not live longer.
    targets.emplace(
        pin, ros::NodeHandle(target_nh_).subscribe<Message>(topic, kUnbounded, take, {}, kAtOnce));
  }
  targets_ = std::move(targets);
}

template <class CoreCommand, class Message, class Translate>
void Commands::receive(const ros::MessageEvent<const Message>& event, const std::string& topic,
                       Translate translate) {
  const std::string sender = event.getPublisherName();
  CoreCommand command;
  const CommandResult translated = translate(
      *event.getMessage(),
      [this](const std::string& frame_id) { return frames_.find(frame_id).pose; }, command);
  if (!translated.accepted()) {
    publishers_.rejected(topic, sender, translated);
  } else if (!loop_.offer(std::move(command), topic, sender)) {
    publishers_.rejected(topic, sender,
                         {Refusal::kLimit, "more than " + std::to_string(CommandQueue::kCapacity) +
                                               " commands wait for the next step"});
  }
}

}  // namespace mass_spring
