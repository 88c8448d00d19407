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

/// In order of precedence.
constexpr PublishingThread::Lane kTopics[] = {
    PublishingThread::kState, PublishingThread::kPins,   PublishingThread::kContacts,
    PublishingThread::kStats, PublishingThread::kPoints, PublishingThread::kMarkers};

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
  std::uint64_t commands;                 ///< applied before
  std::vector<char> pinned;               ///< per particle
  std::vector<Eigen::Isometry3d> shapes;  ///< of contact: where their geometries are
  mass_spring_sim::SolverStats stats;     ///< but for what is measured on the state
};

struct Publishers::ToldWrench {
  ros::Publisher publisher;
  geometry_msgs::WrenchStamped message;
};

Publishers::Publishers(ros::NodeHandle& nh, std::shared_ptr<const Simulation> simulation,
                       const Clock& clock, const FrameFollower& follower,
                       std::function<void(Topic)> on_viewer)
    : frame_id_(simulation->scene().frame_id),
      nh_(nh),
      clock_(clock),
      follower_(follower),
      on_viewer_(std::move(on_viewer)),
      wrenches_(nh,
                [this](Wrenches::Of of) {
                  on_viewer_(of == Wrenches::Of::kPin ? Topic::kPins : Topic::kContacts);
                }),
      simulation_(std::move(simulation)),
      diagnostics_(clock.followed()),
      thread_(maxStates(simulation_->model().particleCount())) {
  const std::size_t max_states = maxStates(simulation_->model().particleCount());
  advertise<visualization_msgs::MarkerArray>(Topic::kMarkers, topics::kMarkers, 1);
  advertise<mass_spring_sim::ParticleStates>(Topic::kState, topics::kState, max_states);
  advertise<sensor_msgs::PointCloud2>(Topic::kPoints, topics::kPoints, 1);
  advertise<mass_spring_sim::PinStates>(Topic::kPins, topics::kPins, 100);
  advertise<mass_spring_sim::SolverStats>(Topic::kStats, topics::kStats, 100);
  topology_publisher_ = nh.advertise<mass_spring_sim::Topology>(topics::kTopology, 1, true);
  applied_publisher_ = nh.advertise<mass_spring_sim::AppliedCommand>(topics::kApplied, 10000);
  rejected_publisher_ = nh.advertise<mass_spring_sim::RejectedCommand>(topics::kRejected, 10000);
  paused_publisher_ = nh.advertise<std_msgs::Bool>(topics::kPaused, 10, true);
  scene_publisher_ = nh.advertise<std_msgs::String>(topics::kScene, 1, true);
  publishScene();
  offerContacts();
}

template <class Message>
void Publishers::advertise(Topic topic, const char* name, std::uint32_t queue) {
  rated_[topic] = nh_.advertise<Message>(
      name, queue, [this, topic](const ros::SingleSubscriberPublisher&) { on_viewer_(topic); });
}

void Publishers::offerContacts() {
  ros::Publisher& publisher = rated_[Topic::kContacts];
  if (simulation_->scene().effects.contact && !publisher) {
    advertise<mass_spring_sim::Contacts>(Topic::kContacts, topics::kContacts, 100);
  } else if (!simulation_->scene().effects.contact && publisher) {
    publisher.shutdown();
    publisher = ros::Publisher();
  }
}

void Publishers::started() {
  report_ = StepReport();
  report_.scheme = simulation_->model().solver.scheme;
  diagnostics_.started(*simulation_);
  publishTopology();
  start_over_ = true;
  tellAll();
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
  drawAnew();
}

void Publishers::stepped(const StepReport& report, const StepMeter::Figures& figures,
                         std::uint64_t overruns) {
  report_ = report;
  figures_ = figures;
  overruns_ = overruns;
  diagnostics_.stepped(report, figures, overruns, *simulation_, follower_.stalePins(),
                       follower_.staleShapes());
  if (report.broken_springs > 0) publishTopology();
  std::shared_ptr<Snapshot> snapshot;
  for (const Topic topic : kTopics) {
    if (!due(topic) || !wanted(topic)) continue;
    if (topic == Topic::kMarkers) {
      const auto now = std::chrono::steady_clock::now();
      if (now < next_markers_) continue;
      next_markers_ = now + std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                                std::chrono::duration<double>(0.5 / rate(topic)));
    }
    post(topic, snapshot);
  }
}

double Publishers::rate(Topic topic) const {
  const PublishRates& rates = simulation_->scene().publish;
  switch (topic) {
    case Topic::kState:
      return rates.state;
    case Topic::kPins:
      return rates.pins;
    case Topic::kContacts:
      return rates.contacts;
    case Topic::kStats:
      return rates.stats;
    case Topic::kPoints:
      return rates.points;
    case Topic::kMarkers:
      return rates.markers;
    default:
      return 0.0;
  }
}

bool Publishers::wanted(Topic topic) const {
  return rate(topic) > 0.0 &&
         (rated_[topic].getNumSubscribers() > 0 ||
          (topic == Topic::kPins && !wrenches_.heard(Wrenches::Of::kPin).empty()) ||
          (topic == Topic::kContacts && !wrenches_.heard(Wrenches::Of::kShape).empty()));
}

void Publishers::tell(Topic topic) {
  std::shared_ptr<Snapshot> snapshot;
  if (wanted(topic)) post(topic, snapshot);
}

void Publishers::tellAll() {
  for (const Topic topic : kTopics) tell(topic);
}

void Publishers::drawAnew() {
  start_over_ = true;
  tell(Topic::kMarkers);
}

void Publishers::post(Topic topic, std::shared_ptr<Snapshot>& snapshot) {
  if (topic == Topic::kPins) return postPins();
  if (topic == Topic::kContacts) return postContacts();
  if (!snapshot) snapshot = this->snapshot();
  if (topic == Topic::kStats) snapshot->stats = stats();
  thread_.post(topic, [this, topic, s = snapshot] {
    if (topic == Topic::kState) publishState(*s);
    if (topic == Topic::kPoints) publishPoints(*s);
    if (topic == Topic::kStats) publishStats(*s);
    if (topic == Topic::kMarkers) publishMarkers(*s);
  });
}

void Publishers::postPins() {
  const auto wrenches = simulation_->pinWrenches();
  std::vector<ToldWrench> told;
  for (const auto& [name, publisher] : wrenches_.heard(Wrenches::Of::kPin)) {
    const auto found = simulation_->pins().all().find(name);
    if (found == simulation_->pins().all().end()) continue;  // its topic is about to go, too
    const Pin& pin = found->second;
    const bool led = follower_.leads(name, pin);
    const Pose frame{pin.target.position,
                     led ? pin.target.orientation : Eigen::Quaterniond::Identity()};
    told.push_back({publisher, stamped(wrenchIn(frame, wrenches.at(name), pin.target.position),
                                       led ? pin.follow_frame : frame_id_)});
  }
  std::optional<mass_spring_sim::PinStates> states;
  if (rated_[Topic::kPins].getNumSubscribers() > 0) {
    states = pinStates(*simulation_, wrenches, follower_.stalePins());
    states->header = header(clock_.stamp());
  }
  thread_.post(Topic::kPins, [this, told = std::move(told), states = std::move(states)] {
    if (states) rated_[Topic::kPins].publish(*states);
    for (const ToldWrench& wrench : told) wrench.publisher.publish(wrench.message);
  });
}

void Publishers::postContacts() {
  const auto& contact = simulation_->scene().effects.contact;
  if (!contact) return;
  const auto wrenches = simulation_->shapeWrenches();
  std::vector<ToldWrench> told;
  const auto heard = wrenches_.heard(Wrenches::Of::kShape);
  const State& state = simulation_->state();
  for (std::size_t s = 0; s < contact->shapes.size(); ++s) {
    const ContactShape& shape = contact->shapes[s];
    const auto publisher = heard.find(shape.name);
    if (publisher == heard.end()) continue;
    const Shape& body = simulation_->model().shapes[s];
    const RigidMotion& motion = state.effects.shapes[s];
    const bool led = follower_.leads(body, motion);
    const Pose pose = motion.at(state.time);
    Pose frame{pose.position, Eigen::Quaterniond::Identity()};
    if (led) {
      frame.orientation = pose.orientation * body.start().orientation.conjugate();
      frame.position -= frame.orientation * body.start().position;
    }
    told.push_back(
        {publisher->second, stamped(wrenchIn(frame, wrenches.at(shape.name), pose.position),
                                    led ? shape.follow_frame : frame_id_)});
  }
  std::optional<mass_spring_sim::Contacts> all;
  if (rated_[Topic::kContacts].getNumSubscribers() > 0) {
    all = contacts(*simulation_, wrenches, follower_.staleShapes());
    all->header = header(clock_.stamp());
  }
  // A copy of the publisher: that goes with the last scene that has contact.
  thread_.post(Topic::kContacts, [publisher = rated_[Topic::kContacts], told = std::move(told),
                                  all = std::move(all)] {
    if (all) publisher.publish(*all);
    for (const ToldWrench& wrench : told) wrench.publisher.publish(wrench.message);
  });
}

geometry_msgs::WrenchStamped Publishers::stamped(const geometry_msgs::Wrench& wrench,
                                                 const std::string& frame_id) const {
  geometry_msgs::WrenchStamped message;
  message.header.stamp = clock_.stamp();
  message.header.frame_id = frame_id;
  message.wrench = wrench;
  return message;
}

mass_spring_sim::SolverStats Publishers::stats() const {
  mass_spring_sim::SolverStats message;
  // Measured here, as yielding springs change with the next step.
  const Energy energy = simulation_->energy();
  message.kinetic_energy = energy.kinetic;
  message.elastic_energy = energy.elastic;
  message.gravity_energy = energy.gravity;
  message.real_time_factor = figures_.real_time_factor;
  message.step_time_median = figures_.median;
  message.step_time_max = figures_.max;
  message.overruns = overruns_;
  message.scheme = name(report_.scheme);
  message.substeps = report_.substeps;
  message.newton_iterations = report_.newton_iterations;
  message.linear_iterations = report_.linear_iterations;
  message.residual = report_.residual;
  message.estimated_error = report_.estimated_error;
  message.budget_used = report_.budget_used;
  message.unconverged_steps = simulation_->totals().unconverged_steps;
  message.rejected_steps = simulation_->totals().rejected_steps;
  message.contacts = particlesInContact(*simulation_);
  message.active_forces = simulation_->activeForces();
  message.pins = static_cast<std::uint32_t>(simulation_->pins().all().size());
  message.rejected_commands = rejected_commands_;
  return message;
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

mass_spring_sim::ParticleStates Publishers::state() const {
  mass_spring_sim::ParticleStates message = toMessage(simulation_->state());
  message.header = header(clock_.stamp());
  message.commands = applied_commands_;
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
  snapshot->commands = applied_commands_;
  snapshot->pinned = simulation_->pins().mask();
  const std::vector<Shape>& shapes = snapshot->model->shapes;
  const State& state = snapshot->state;
  for (std::size_t s = 0; s < shapes.size(); ++s) {
    const PlacedShape placed(shapes[s], state.effects.shapes[s], state.time);
    snapshot->shapes.push_back(placed.geometryPose());
  }
  return snapshot;
}

/// Whole periods of simulated time are counted, so that no rate drifts and each step is due once
/// where the rate is that of the steps.
bool Publishers::due(Topic topic) const {
  const double periods_per_step = rate(topic) / simulation_->scene().rate;
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
  message.commands = snapshot.commands;
  rated_[Topic::kState].publish(message);
}

void Publishers::publishPoints(const Snapshot& snapshot) {
  sensor_msgs::PointCloud2 message = pointCloud(*snapshot.model, snapshot.state);
  message.header = header(snapshot.stamp);
  rated_[Topic::kPoints].publish(message);
}

void Publishers::publishStats(const Snapshot& snapshot) {
  mass_spring_sim::SolverStats message = snapshot.stats;
  message.header = header(snapshot.stamp);
  message.step = snapshot.state.step;
  message.sim_time = snapshot.state.time;
  message.max_speed = maxSpeed(snapshot.state);
  message.max_stretch = maxStretch(*snapshot.model, snapshot.state);
  rated_[Topic::kStats].publish(message);
}

void Publishers::publishMarkers(const Snapshot& snapshot) {
  const Simulation& simulation = *snapshot.simulation;
  bool start_over = start_over_.exchange(false);
  // A last drawing of another scene may have taken it.
  start_over = start_over || drawn_.lock() != snapshot.simulation;
  if (start_over) {
    drawn_ = snapshot.simulation;
    markers_.emplace(simulation.scene(), *snapshot.model, markersPerWallSecond(simulation.scene()));
  } else if (drawn_model_.lock() != snapshot.model) {
    markers_->follow(*snapshot.model);
  }
  drawn_model_ = snapshot.model;
  rated_[Topic::kMarkers].publish(
      markers_->draw(snapshot.state.positions, snapshot.pinned, snapshot.stamp, start_over,
                     shapeMarkers(simulation.scene(), snapshot.shapes, snapshot.stamp)));
}

}  // namespace mass_spring
