#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "mass_spring_sim/model.h"

namespace mass_spring {

/// What a rival is given of a scene.
struct RivalScene {
  const Model& model;        ///< outlives the rival
  Eigen::Vector3d gravity;   ///< m/s^2
  std::vector<char> pinned;  ///< per particle; pinned particles stand still
  double step;               ///< s, of one call of step()
};

/// A scene run by other code than the library's.
class Rival {
 public:
  virtual ~Rival() = default;
  virtual void step() = 0;
  /// m. Not part of a step's time: each keeps them in a form of its own.
  virtual Vectors positions() const = 0;
};

struct RivalSetting {
  std::string text;
  std::function<std::unique_ptr<Rival>(const RivalScene&)> make;
};

/// One rival at ever finer settings, the cheapest first.
struct RivalSeries {
  std::string name;
  std::vector<RivalSetting> settings;
};

}  // namespace mass_spring
