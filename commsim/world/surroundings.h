#pragma once

#include <optional>
#include <vector>

#include "common/core/ids.h"
#include "commsim/world/scene.h"

namespace muster::world {

struct Body {
  RobotId id;
  Vec3 p = Vec3::Zero();
  double radius_m = 0;
};

/// What a robot's rays can meet at one instant: the site, and the other robots' bodies as spheres
/// (analytic, so that moving them costs nothing).
class Surroundings {
 public:
  Surroundings(const Scene& scene, std::vector<Body> bodies)
      : scene_(scene), bodies_(std::move(bodies)) {}

  const Scene& scene() const { return scene_; }
  std::vector<Body>& bodies() { return bodies_; }
  const std::vector<Body>& bodies() const { return bodies_; }
  /// Bodies other than `self` that come within `range_m` of `p`.
  std::vector<Body> near(const Vec3& p, double range_m, RobotId self) const;

  /// Nothing of the site and no other body between a and b; `slack_m` before b does not count.
  bool sees(const Vec3& a, const Vec3& b, RobotId self, double slack_m = 0) const;

 private:
  const Scene& scene_;
  std::vector<Body> bodies_;
};

/// Distance along the unit ray to the sphere, nullopt when it is missed, behind, or around the
/// origin.
std::optional<double> cast_sphere(const Vec3& origin, const Vec3& unit_direction, const Body& body);

}  // namespace muster::world
