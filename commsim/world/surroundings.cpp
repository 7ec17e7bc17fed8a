#include "commsim/world/surroundings.h"

#include <cmath>

namespace muster::world {

std::optional<double> cast_sphere(const Vec3& origin, const Vec3& unit_direction,
                                  const Body& body) {
  const Vec3 to_center = body.p - origin;
  const double along = to_center.dot(unit_direction);
  if (along <= 0) return std::nullopt;
  const double off2 = to_center.squaredNorm() - along * along;
  const double r2 = body.radius_m * body.radius_m;
  if (off2 > r2) return std::nullopt;
  const double distance = along - std::sqrt(r2 - off2);
  if (distance <= 0) return std::nullopt;
  return distance;
}

std::vector<Body> Surroundings::near(const Vec3& p, double range_m, RobotId self) const {
  std::vector<Body> result;
  for (const Body& b : bodies_) {
    if (b.id != self && (b.p - p).norm() <= range_m + b.radius_m) result.push_back(b);
  }
  return result;
}

bool Surroundings::sees(const Vec3& a, const Vec3& b, RobotId self, double slack_m) const {
  const Vec3 d = b - a;
  const double distance = d.norm();
  if (distance <= slack_m || distance < 1e-9) return true;
  const Vec3 direction = d / distance;
  for (const Body& body : near(a, distance, self)) {
    const auto hit = cast_sphere(a, direction, body);
    if (hit && *hit < distance - slack_m) return false;
  }
  return !scene_.cast(a, direction, distance - slack_m);
}

}  // namespace muster::world
