#pragma once

#include <optional>
#include <vector>

#include "commsim/world/reachable.h"

namespace muster::world {

/// What a view of a point must satisfy. The camera may turn about z as it likes, so only its pitch
/// limits it.
struct ViewRule {
  double min_elevation_rad = 0, max_elevation_rad = 0;  ///< of the point, seen from the camera
  double range_m = 0;
  double max_incidence_rad = 0;

  /// Of a vehicle's camera, a little inside its limits, so that a planner working on cells finds a
  /// view too.
  static ViewRule of_camera(const mission::Vehicle& vehicle, double range_m,
                            double max_incidence_rad);
};

/// Looks for places from which a robot can see points of a scene, over a fixed pattern of
/// directions and distances.
class ViewFinder {
 public:
  /// Both must outlive this.
  ViewFinder(const Scene& scene, const ReachableSpace& reachable, const mission::Mission& mission);

  /// A reachable place that sees `point` of a surface with outward `normal` by `rule`.
  std::optional<Vec3> find(const Vec3& point, const Vec3& normal, const ViewRule& rule) const;
  /// The side of a surface that could be seen at all lies outside solids: false when `normal`
  /// points into one.
  bool is_outside(const Vec3& point, const Vec3& normal) const;

 private:
  const Scene& scene_;
  const ReachableSpace& reachable_;
  bool winding_tells_ =
      true;  ///< false for meshes that show a robot at its start the back of a triangle
};

}  // namespace muster::world
