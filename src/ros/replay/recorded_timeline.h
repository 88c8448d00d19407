#pragma once

#include <cstdint>
#include <string>

#include "mass_spring_sim/command.h"
#include "mass_spring_sim/scene.h"

namespace mass_spring {

/// The commands of a run as the timeline of a scene that does the same run without a node.
class RecordedTimeline {
 public:
  /// The run begins anew.
  void startOver(const Scene& scene);
  /// @param step  the first that the command acts on
  void add(std::uint64_t step, Command command);
  /// The run goes on with what no timeline can say.
  void refuse(const std::string& what);

  /// @throws BagError if no timeline can say it
  std::string toYaml() const;

 private:
  Scene scene_;
  std::string obstacle_;  ///< the first that was refused
};

}  // namespace mass_spring
