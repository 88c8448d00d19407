#pragma once

#include <ros/time.h>
#include <visualization_msgs/MarkerArray.h>

#include <cstdint>
#include <string>
#include <vector>

#include "mass_spring_sim/model.h"
#include "mass_spring_sim/scene.h"
#include "mass_spring_sim/state.h"
#include "surfaces.h"

namespace mass_spring {

/// How much of a scene the markers show: as much as 60 MB/s at the asked rate can carry.
enum class Detail {
  kFull,        ///< particles, all springs, surfaces with a front and a back
  kStructural,  ///< the same with structural springs alone
  kSurface,     ///< surfaces instead of particles and springs, with one color for both sides of a
                ///< triangle; a rope has particles and structural springs instead of its tube
  kPoints,      ///< particles
};

/// Draws a model: at most four markers per object, NAME/particles, NAME/springs, NAME/surface and
/// NAME/pins, each of id 0. An empty marker is deleted, as RViz dislikes empty lists. The surface
/// of a rope is a tube. Springs and surfaces turn red where they are stretched and blue where they
/// are compressed. All colors are in [0, 1].
class Markers {
 public:
  /// @param model  of that scene; must outlive this, or the next call of follow()
  /// @param rate   Hz of wall time at which markers will be published at the most
  Markers(const Scene& scene, const Model& model, double rate);

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
    double spacing;                      ///< m between neighbors, > 0
    double diameter;                     ///< m, of a rope drawn as a tube; 0 for all else
    double pin_size;                     ///< m, > 0
    std::vector<std::uint32_t> springs;  ///< those drawn
    Triangles triangles;                 ///< of the surface
    bool particles, net, surface;        ///< net: springs are drawn, or were
    bool back;                           ///< the surface has a back of its own color
  };

  Look look(const Scene& scene, const ModelObject& object) const;
  void chooseParts(const ModelObject& object, Look& look) const;
  visualization_msgs::Marker& next(const std::string& ns, int type, const ModelObject& object,
                                   const ros::Time& stamp);
  void drawParticles(const ModelObject& object, const Look& look, const Vectors& positions,
                     const ros::Time& stamp);
  void drawSprings(const ModelObject& object, const Look& look, const Vectors& positions,
                   const ros::Time& stamp);
  void drawSurface(const ModelObject& object, const Look& look, const Vectors& positions,
                   const ros::Time& stamp);
  void drawTriangles(const ModelObject& object, const Look& look, const Vectors& positions,
                     const Vectors& colors, visualization_msgs::Marker& marker) const;
  /// By the mean strain of the structural springs of each particle of an object, in full light.
  Vectors particleColors(const ModelObject& object, const Vectors& positions) const;
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
