#pragma once

#include <optional>
#include <vector>

#include "commsim/world/reachable.h"

namespace muster::world {

/// What a view of a point must satisfy. The camera may turn about z as it likes, so only its pitch
/// limits it.
class ViewRule {
 public:
  /// Of a vehicle's camera, a little inside its limits, so that a planner working on cells finds a
  /// view too.
  ViewRule(const mission::Vehicle& vehicle, double range_m, double max_incidence_rad);

  /// From the point towards cameras, for a surface that faces +x; the straightest come first.
  const std::vector<Vec3>& directions() const { return directions_; }
  double range_m() const { return range_m_; }
  double least_cos() const { return least_cos_; }
  bool operator==(const ViewRule&) const = default;

 private:
  double min_elevation_rad_, max_elevation_rad_;  ///< of the point, seen from the camera
  double range_m_, least_cos_;
  std::vector<Vec3> directions_;
};

/// Looks for places from which a robot can see points of a scene, over a fixed pattern of
/// directions and distances.
class ViewFinder {
 public:
  /// Both must outlive this.
  ViewFinder(const Scene& scene, const ReachableSpace& reachable, const mission::Mission& mission);

  /// A reachable place that sees `point` of a surface with outward `normal` by `rule`.
  std::optional<Vec3> find(const Vec3& point, const Vec3& normal, const ViewRule& rule) const;
  /// Is there one? Looks from direction `lucky` first and leaves there what was found: what sees a
  /// point mostly sees its neighbours.
  bool can_see(const Vec3& point, const Vec3& normal, const ViewRule& rule,
               std::size_t& lucky) const;
  /// The side of a surface that could be seen at all lies outside solids: false when `normal`
  /// points into one.
  bool is_outside(const Vec3& point, const Vec3& normal) const;

 private:
  std::optional<Vec3> look_along(const Vec3& d, const Vec3& point, const Vec3& normal,
                                 const ViewRule& rule) const;

  const Scene& scene_;
  const ReachableSpace& reachable_;
  bool winding_tells_ =
      true;  ///< false for meshes that show a robot at its start the back of a triangle
};

}  // namespace muster::world
