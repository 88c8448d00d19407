#pragma once

#include <mass_spring_sim/AppliedCommand.h>
#include <mass_spring_sim/SolverStats.h>
#include <ros/ros.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "clock.h"
#include "diagnostics.h"
#include "frame_follower.h"
#include "markers.h"
#include "mass_spring_sim/simulation.h"
#include "publishing_thread.h"
#include "step_meter.h"
#include "throttle.h"
#include "wrenches.h"

namespace mass_spring {

/// All topics but /clock, and the diagnostics. The thread that steps hands in what has happened;
/// messages are built and published on another, and only if somebody listens.
class Publishers {
 public:
  /// What is published at a rate: all lanes but that of events. ~wrenches go with ~pins, ~contacts.
  using Topic = PublishingThread::Lane;

  /// @param nh         private node handle
  /// @param follower   of the pins and shapes that follow frames
  /// @param on_viewer  called, on another thread, when somebody subscribes to one of these
  Publishers(ros::NodeHandle& nh, std::shared_ptr<const Simulation> simulation, const Clock& clock,
             const FrameFollower& follower, std::function<void(Topic)> on_viewer);

  // For the thread that steps, between steps.

  /// The simulation stands at its start: at first, and after a reset.
  void started();
  /// Another simulation has taken over, of the same frame_id: where the old one stood, or at its
  /// start.
  void replaced(std::shared_ptr<const Simulation> simulation, bool continued);
  /// Tells the topology anew where springs broke.
  void stepped(const StepReport& report, const StepMeter::Figures& figures, std::uint64_t overruns);
  /// A step failed; the simulation stands where it was, or at an earlier step.
  /// @param other_springs  that state has broken springs whole again
  void failed(const StepReport& report, bool other_springs);
  void paused(bool paused);
  /// Of the simulation as it stands.
  mass_spring_sim::ParticleStates state() const;
  /// Adds header and number to the message.
  void applied(mass_spring_sim::AppliedCommand message);
  /// Tells of the simulation as it stands, while no step does.
  void tell(Topic topic);
  void tellAll();
  /// Draws it for viewers that know nothing yet.
  void drawAnew();

  // For any thread.

  /// Offers ~wrenches of these and no others. May wait for the master.
  void offerWrenches(const Names& names) { wrenches_.offer(names); }

  /// Counts it, too, and warns, once a second at the most.
  void rejected(const std::string& topic, const std::string& sender, const CommandResult& result);

 private:
  struct Snapshot;
  struct ToldWrench;
  /// Of the simulation as it stands.
  std::shared_ptr<Snapshot> snapshot() const;
  template <class Message>
  void advertise(Topic topic, const char* name, std::uint32_t queue);
  double rate(Topic topic) const;  ///< that the scene asks for [Hz]
  bool due(Topic topic) const;
  /// Is it asked for, and has it subscribers?
  bool wanted(Topic topic) const;
  /// @param snapshot  made when one is needed
  void post(Topic topic, std::shared_ptr<Snapshot>& snapshot);
  void postPins();
  void postContacts();
  geometry_msgs::WrenchStamped stamped(const geometry_msgs::Wrench& wrench,
                                       const std::string& frame_id) const;
  mass_spring_sim::SolverStats stats() const;
  /// There is ~contacts only where a scene has contact.
  void offerContacts();
  void publishScene();
  void publishTopology();
  std_msgs::Header header(const ros::Time& stamp) const;
  void publishState(const Snapshot& snapshot);
  void publishPoints(const Snapshot& snapshot);
  void publishStats(const Snapshot& snapshot);
  void publishMarkers(const Snapshot& snapshot);

  const std::string frame_id_;
  ros::NodeHandle nh_;
  const Clock& clock_;
  const FrameFollower& follower_;
  const std::function<void(Topic)> on_viewer_;
  Wrenches wrenches_;
  std::array<ros::Publisher, PublishingThread::kLaneCount> rated_;  ///< by topic
  ros::Publisher topology_publisher_, applied_publisher_, rejected_publisher_, paused_publisher_,
      scene_publisher_;
  std::atomic<bool> start_over_{false};  ///< the next markers begin with a DELETEALL
  std::atomic<std::uint64_t> rejected_commands_{0};
  Throttle rejected_throttle_;

  // Of the thread that steps.
  std::shared_ptr<const Simulation> simulation_;
  std::chrono::steady_clock::time_point next_markers_;
  StepReport report_;  ///< of the last step
  StepMeter::Figures figures_;
  std::uint64_t overruns_ = 0;
  std::uint64_t applied_commands_ = 0;

  // Of the thread that publishes.
  std::weak_ptr<const Simulation> drawn_;  ///< by markers_; a replaced one is not kept for that
  std::weak_ptr<const Model> drawn_model_;
  std::optional<Markers> markers_;

  Diagnostics diagnostics_;
  PublishingThread thread_;  ///< last, so that it ends before what it uses
};

}  // namespace mass_spring
