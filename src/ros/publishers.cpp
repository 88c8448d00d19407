#include "publishers.h"

#include <mass_spring_sim/ParticleStates.h>
#include <mass_spring_sim/RejectedCommand.h>
#include <mass_spring_sim/SolverStats.h>
#include <mass_spring_sim/Topology.h>
#include <std_msgs/Bool.h>
#include <std_msgs/String.h>
#include <visualization_msgs/MarkerArray.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "conversions.h"
#include "effects/contact.h"
#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/scene_reader.h"
#include "shape_markers.h"
#include "topics.h"

namespace mass_spring {

namespace {

/// States that may wait to be published or sent: 64 MB of them, yet not fewer than 100.
std::size_t maxStates(std::uint32_t particles) {
  const std::size_t bytes = std::size_t{particles} * 6 * sizeof(double);
  return std::clamp<std::size_t>((std::size_t{64} << 20) / bytes, 100, 10000);
}

/// A fast simulation shows its markers twice as often as asked for in wall time, not more.
double markersPerWallSecond(const Scene& scene) {
  const double factor = scene.real_time_factor;
  return scene.publish.markers * (factor == 0.0 ? 2.0 : std::clamp(factor, 1.0, 2.0));
}

/// A particle may touch several shapes.
std::uint32_t particlesInContact(const Simulation& simulation) {
  std::uint32_t count = 0, last = std::numeric_limits<std::uint32_t>::max();
  for (const Touch& touch : simulation.touches()) {
    if (touch.particle != last) ++count;
    last = touch.particle;
  }
  return count;
}

}  // namespace

struct Publishers::Snapshot {
  std::shared_ptr<const Simulation> simulation;  ///< whose scene is constant
  std::shared_ptr<const Model> model;            ///< while it goes on, perhaps, with another one
  ros::Time stamp;
  State state;
  std::vector<char> pinned;               ///< per particle
  std::vector<Eigen::Isometry3d> shapes;  ///< of contact: where their geometries are
  mass_spring_sim::SolverStats stats;     ///< but for what is measured on the state
};

Publishers::Publishers(ros::NodeHandle& nh, std::shared_ptr<const Simulation> simulation,
                       const Clock& clock, const FrameFollower& follower,
                       std::function<void()> on_viewer)
    : frame_id_(simulation->scene().frame_id),
      nh_(nh),
      clock_(clock),
      follower_(follower),
      simulation_(std::move(simulation)),
      diagnostics_(clock.followed()),
      thread_(maxStates(simulation_->model().particleCount())) {
  const std::size_t max_states = maxStates(simulation_->model().particleCount());
  markers_publisher_ = nh.advertise<visualization_msgs::MarkerArray>(
      topics::kMarkers, 1, [on_viewer](const ros::SingleSubscriberPublisher&) { on_viewer(); });
  state_publisher_ = nh.advertise<mass_spring_sim::ParticleStates>(topics::kState, max_states);
  topology_publisher_ = nh.advertise<mass_spring_sim::Topology>(topics::kTopology, 1, true);
  points_publisher_ = nh.advertise<sensor_msgs::PointCloud2>(topics::kPoints, 1);
  pins_publisher_ = nh.advertise<mass_spring_sim::PinStates>(topics::kPins, 100);
  stats_publisher_ = nh.advertise<mass_spring_sim::SolverStats>(topics::kStats, 100);
  applied_publisher_ = nh.advertise<mass_spring_sim::AppliedCommand>(topics::kApplied, 10000);
  rejected_publisher_ = nh.advertise<mass_spring_sim::RejectedCommand>(topics::kRejected, 10000);
  paused_publisher_ = nh.advertise<std_msgs::Bool>(topics::kPaused, 10, true);
  scene_publisher_ = nh.advertise<std_msgs::String>(topics::kScene, 1, true);
  publishScene();
  offerContacts();
}

void Publishers::offerContacts() {
  if (simulation_->scene().effects.contact && !contacts_publisher_) {
    contacts_publisher_ = nh_.advertise<mass_spring_sim::Contacts>(topics::kContacts, 100);
  } else if (!simulation_->scene().effects.contact && contacts_publisher_) {
    contacts_publisher_.shutdown();
    contacts_publisher_ = ros::Publisher();
  }
}

void Publishers::started() {
  diagnostics_.started(*simulation_);
  publishTopology();
  if (simulation_->scene().publish.state > 0.0 && state_publisher_.getNumSubscribers() > 0) {
    thread_.post(PublishingThread::kState, [this, s = snapshot()] { publishState(*s); });
  }
  redraw(true);
}

void Publishers::replaced(std::shared_ptr<const Simulation> simulation, bool continued) {
  simulation_ = std::move(simulation);
  publishScene();
  offerContacts();
  if (!continued) {
    started();
    return;
  }
  diagnostics_.started(*simulation_);
  publishTopology();
  redraw(true);
}

void Publishers::stepped(const StepReport& report, const StepMeter::Figures& figures,
                         std::uint64_t overruns) {
  const PublishRates& rates = simulation_->scene().publish;
  diagnostics_.stepped(report, figures, overruns, *simulation_, follower_.stalePins(),
                       follower_.staleShapes());
  if (report.broken_springs > 0) publishTopology();
  const bool state = due(rates.state) && state_publisher_.getNumSubscribers() > 0;
  if (due(rates.pins) && pins_publisher_.getNumSubscribers() > 0) {
    thread_.post(PublishingThread::kPins,
                 [this, message = pinStates(*simulation_, follower_.stalePins()),
                  stamp = clock_.stamp()]() mutable {
                   message.header = header(stamp);
                   pins_publisher_.publish(message);
                 });
  }
  if (contacts_publisher_ && due(rates.contacts) && contacts_publisher_.getNumSubscribers() > 0) {
    thread_.post(PublishingThread::kContacts,
                 [this, publisher = contacts_publisher_,
                  message = contacts(*simulation_, follower_.staleShapes()),
                  stamp = clock_.stamp()]() mutable {
                   message.header = header(stamp);
                   publisher.publish(message);
                 });
  }
  const bool stats = due(rates.stats) && stats_publisher_.getNumSubscribers() > 0;
  const auto now = std::chrono::steady_clock::now();
  const bool markers =
      due(rates.markers) && now >= next_markers_ && markers_publisher_.getNumSubscribers() > 0;
  const bool points = due(rates.points) && points_publisher_.getNumSubscribers() > 0;
  if (!state && !points && !stats && !markers) return;

  const std::shared_ptr<Snapshot> s = snapshot();
  if (state) thread_.post(PublishingThread::kState, [this, s] { publishState(*s); });
  if (points) thread_.post(PublishingThread::kPoints, [this, s] { publishPoints(*s); });
  if (stats) {
    mass_spring_sim::SolverStats& message = s->stats;
    // Measured here, as yielding springs change with the next step.
    const Energy energy = mass_spring::energy(*s->model, s->state);
    message.kinetic_energy = energy.kinetic;
    message.elastic_energy = energy.elastic;
    message.gravity_energy = energy.gravity;
    message.real_time_factor = figures.real_time_factor;
    message.step_time_median = figures.median;
    message.step_time_max = figures.max;
    message.overruns = overruns;
    message.scheme = name(report.scheme);
    message.substeps = report.substeps;
    message.newton_iterations = report.newton_iterations;
    message.linear_iterations = report.linear_iterations;
    message.residual = report.residual;
    message.estimated_error = report.estimated_error;
    message.budget_used = report.budget_used;
    message.unconverged_steps = simulation_->totals().unconverged_steps;
    message.rejected_steps = simulation_->totals().rejected_steps;
    message.contacts = particlesInContact(*simulation_);
    message.active_forces = simulation_->activeForces();
    message.pins = static_cast<std::uint32_t>(simulation_->pins().all().size());
    message.rejected_commands = rejected_commands_;
    thread_.post(PublishingThread::kStats, [this, s] { publishStats(*s); });
  }
  if (markers) {
    next_markers_ = now + std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                              std::chrono::duration<double>(0.5 / rates.markers));
    thread_.post(PublishingThread::kMarkers, [this, s] { publishMarkers(*s); });
  }
}

void Publishers::failed(const StepReport& report, bool other_springs) {
  diagnostics_.failed(report.message);
  if (other_springs) publishTopology();
}

void Publishers::paused(bool paused) {
  diagnostics_.paused(paused);
  std_msgs::Bool message;
  message.data = paused;
  paused_publisher_.publish(message);
}

void Publishers::redraw(bool start_over) {
  if (start_over) start_over_ = true;
  if (simulation_->scene().publish.markers == 0.0 || markers_publisher_.getNumSubscribers() == 0) {
    return;
  }
  thread_.post(PublishingThread::kMarkers, [this, s = snapshot()] { publishMarkers(*s); });
}

mass_spring_sim::ParticleStates Publishers::state() const {
  mass_spring_sim::ParticleStates message = toMessage(simulation_->state());
  message.header = header(clock_.stamp());
  return message;
}

void Publishers::applied(mass_spring_sim::AppliedCommand message) {
  message.number = ++applied_commands_;
  diagnostics_.applied();
  if (applied_publisher_.getNumSubscribers() == 0) return;
  // A run that starts anew has its start and this at the same time, whatever clock that is of: in a
  // recording, what belongs to which run.
  const bool start = message.kind == mass_spring_sim::AppliedCommand::RESET ||
                     message.kind == mass_spring_sim::AppliedCommand::RELOAD;
  message.header = header(start ? clock_.stamp() : clock_.now());
  thread_.post(PublishingThread::kEvents,
               [this, message = std::move(message)] { applied_publisher_.publish(message); });
}

void Publishers::rejected(const std::string& topic, const std::string& sender,
                          const CommandResult& result) {
  ++rejected_commands_;
  diagnostics_.rejected(result.message);
  if (rejected_throttle_.ready()) {
    ROS_WARN_STREAM("Refused a command of " << sender << " on " << topic << ": " << result.message);
  }
  if (rejected_publisher_.getNumSubscribers() == 0) return;
  mass_spring_sim::RejectedCommand message;
  message.header = header(clock_.now());
  message.topic = topic;
  message.sender = sender;
  message.reason = static_cast<std::uint8_t>(result.refusal);
  message.message = result.message;
  thread_.post(PublishingThread::kEvents,
               [this, message = std::move(message)] { rejected_publisher_.publish(message); });
}

std::shared_ptr<Publishers::Snapshot> Publishers::snapshot() const {
  auto snapshot = std::make_shared<Snapshot>();
  snapshot->simulation = simulation_;
  snapshot->model = simulation_->sharedModel();
  snapshot->stamp = clock_.stamp();
  snapshot->state = simulation_->state();
  snapshot->pinned = simulation_->pins().mask();
  if (const Contact* contact = simulation_->model().contact) {
    setTime(simulation_->model(), simulation_->state().time);
    for (const Shape& shape : contact->shapes()) snapshot->shapes.push_back(shape.geometryPose());
  }
  return snapshot;
}

/// Whole periods of simulated time are counted, so that no rate drifts and each step is due once
/// where the rate is that of the steps.
bool Publishers::due(double rate) const {
  const double periods_per_step = rate / simulation_->scene().rate;
  const double step = static_cast<double>(simulation_->state().step);
  return std::floor(step * periods_per_step) > std::floor((step - 1.0) * periods_per_step);
}

void Publishers::publishScene() {
  thread_.post(PublishingThread::kEvents, [this, simulation = simulation_] {
    std_msgs::String message;
    message.data = toYaml(simulation->scene());
    scene_publisher_.publish(message);
  });
}

void Publishers::publishTopology() {
  thread_.post(PublishingThread::kEvents,
               [this, model = simulation_->sharedModel(), stamp = clock_.stamp()] {
                 mass_spring_sim::Topology message = toMessage(*model);
                 message.header = header(stamp);
                 topology_publisher_.publish(message);
               });
}

std_msgs::Header Publishers::header(const ros::Time& stamp) const {
  std_msgs::Header header;
  header.stamp = stamp;
  header.frame_id = frame_id_;
  return header;
}

void Publishers::publishState(const Snapshot& snapshot) {
  mass_spring_sim::ParticleStates message = toMessage(snapshot.state);
  message.header = header(snapshot.stamp);
  state_publisher_.publish(message);
}

void Publishers::publishPoints(const Snapshot& snapshot) {
  sensor_msgs::PointCloud2 message = pointCloud(*snapshot.model, snapshot.state);
  message.header = header(snapshot.stamp);
  points_publisher_.publish(message);
}

void Publishers::publishStats(const Snapshot& snapshot) {
  mass_spring_sim::SolverStats message = snapshot.stats;
  message.header = header(snapshot.stamp);
  message.step = snapshot.state.step;
  message.sim_time = snapshot.state.time;
  message.max_speed = maxSpeed(snapshot.state);
  message.max_stretch = maxStretch(*snapshot.model, snapshot.state);
  stats_publisher_.publish(message);
}

void Publishers::publishMarkers(const Snapshot& snapshot) {
  const Simulation& simulation = *snapshot.simulation;
  bool start_over = start_over_.exchange(false);
  // A last drawing of another scene may have taken it.
  start_over = start_over || drawn_.lock() != snapshot.simulation;
  if (start_over) {
    drawn_ = snapshot.simulation;
    markers_.emplace(*snapshot.model, frame_id_, markersPerWallSecond(simulation.scene()));
  } else if (drawn_model_.lock() != snapshot.model) {
    markers_->follow(*snapshot.model);
  }
  drawn_model_ = snapshot.model;
  markers_publisher_.publish(
      markers_->draw(snapshot.state.positions, snapshot.pinned, snapshot.stamp, start_over,
                     shapeMarkers(simulation.scene(), snapshot.shapes, snapshot.stamp)));
}

}  // namespace mass_spring
