#pragma once

#include <ros/time.h>
#include <visualization_msgs/MarkerArray.h>

#include <cstdint>
#include <string>
#include <vector>

#include "mass_spring_sim/model.h"
#include "mass_spring_sim/state.h"

namespace mass_spring {

/// How much of a scene the markers show: as much as 60 MB/s at the asked rate can carry.
enum class Detail {
  kFull,        ///< particles, all springs coloured by strain, surfaces
  kStructural,  ///< particles, structural springs coloured by strain, surfaces
  kSurface,  ///< surfaces coloured by strain instead of particles and springs; the rest as before
  kPoints,   ///< particles
};

/// Draws a model: at most four markers per object, NAME/particles, NAME/springs, NAME/surface and
/// NAME/pins, each of id 0. What there is nothing of is deleted, as RViz dislikes empty lists.
class Markers {
 public:
  /// @param rate  Hz of wall time at which markers will be published at the most
  Markers(const Model& model, std::string frame_id, double rate);

  Detail detail() const { return detail_; }
  /// Springs and triangles are from now on those of another model of the same objects, torn or
  /// whole again; the look of all else stays, and what there is nothing left of is deleted.
  void follow(const Model& model);

  /// @param pinned      per particle
  /// @param start_over  begin with a DELETEALL
  /// @param shapes      what stands around; drawn after the objects
  /// @return valid until the next call
  const visualization_msgs::MarkerArray& draw(const Vectors& positions,
                                              const std::vector<char>& pinned,
                                              const ros::Time& stamp, bool start_over,
                                              std::vector<visualization_msgs::Marker> shapes = {});

 private:
  struct Look {
    double spacing;                      ///< m between neighbours, > 0
    std::vector<std::uint32_t> springs;  ///< those drawn
    std::vector<double> edge_lengths;    ///< m at the start, 3 per triangle, if faces show strain
    bool particles, net, surface;        ///< net: springs are drawn, or were
  };

  Look look(const ModelObject& object) const;
  void chooseSprings(const ModelObject& object, Look& look) const;
  visualization_msgs::Marker& next(const std::string& ns, int type, const ModelObject& object,
                                   const ros::Time& stamp);
  void drawParticles(const ModelObject& object, const Look& look, const Vectors& positions,
                     const ros::Time& stamp);
  void drawSprings(const ModelObject& object, const Look& look, const Vectors& positions,
                   const ros::Time& stamp);
  void drawSurface(const ModelObject& object, const Look& look, const Vectors& positions,
                   const ros::Time& stamp);
  void drawPins(const ModelObject& object, const Look& look, const Vectors& positions,
                const std::vector<char>& pinned, const ros::Time& stamp);

  const Model* model_;
  std::string frame_id_;
  Detail detail_;
  std::vector<Look> looks_;                ///< per object
  visualization_msgs::MarkerArray array_;  ///< kept for its memory
  std::size_t used_ = 0;                   ///< of array_.markers
};

}  // namespace mass_spring
