#pragma once

#include <mass_spring_sim/AppliedCommand.h>
#include <mass_spring_sim/ParticleStates.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "mass_spring_sim/simulation.h"

namespace mass_spring {

/// What a node tells of a run, to be written into a bag: as it is, or after somebody has had a hand
/// in it.
struct Told {
  std::string scene;  ///< that it begins with
  std::vector<mass_spring_sim::AppliedCommand> commands;
  std::vector<mass_spring_sim::ParticleStates> states;

  /// Into a new bag, or one that there is.
  void write(const std::string& file, const std::string& node = "/mass_spring") const;
};

/// Runs a scene and notes what a node would tell of it.
class Recording : public Told {
 public:
  /// Of wall time, which always goes on, or of simulated time, which stands still between steps.
  enum class Stamps { kWall, kSimulated };

  explicit Recording(const std::string& scene, Stamps stamps = Stamps::kWall);
  Recording(const Recording&) = delete;

  void apply(const Command& command, const std::string& sender = "/somebody");
  /// As many, or to the one that fails.
  void step(int steps);
  void reset();
  void reload(const std::string& scene);
  void setState(const Vectors& positions, const Vectors& velocities);
  /// As it stands; step(), reset() and reload() tell of it by themselves.
  void tellState();
  const Simulation& simulation() const { return *simulation_; }

 private:
  void take(const std::string& scene);
  void tell(mass_spring_sim::AppliedCommand message, const std::string& sender);
  void tell(std::uint8_t kind);
  void startOver();

  const Stamps stamps_;
  ros::Time start_{1000, 0}, now_ = start_;
  std::unique_ptr<Simulation> simulation_;
};

/// A folder of this test, removed with it.
class Folder {
 public:
  Folder();
  ~Folder();
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

/// A sheet on one corner, a rope that the timeline pulls at, and a ball that can be moved.
extern const char* const kRecordedScene;

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace mass_spring
