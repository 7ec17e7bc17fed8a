#include "commsim/world/view.h"

#include <algorithm>
#include <cmath>

namespace muster::world {
namespace {

constexpr double kRangeMargin_m = 0.2;
constexpr double kAngleMargin_rad = 0.035;  // 2°
constexpr double kDistanceShares[] = {0.17, 0.3, 0.45, 0.7, 0.95};
constexpr double kElevationShares[] = {0.5, 0.1, 0.9, 0.3, 0.7, 0.0, 1.0};
constexpr int kAzimuths = 16;

/// Turns a rule's directions to a surface with this normal.
class Turn {
 public:
  explicit Turn(const Vec3& normal) {
    const double flat = std::hypot(normal.x(), normal.y());
    if (flat > 1e-9) c_ = normal.x() / flat, s_ = normal.y() / flat;
  }
  Vec3 operator()(const Vec3& local) const {
    return {c_ * local.x() - s_ * local.y(), s_ * local.x() + c_ * local.y(), local.z()};
  }

 private:
  double c_ = 1, s_ = 0;
};

/// As the cameras judge it (Surroundings::sees), with nobody in the way: the spot of an edge that
/// another surface runs along by less than a ray's tolerance is in nobody's sight.
bool in_sight(const Scene& scene, const Vec3& eye, const Vec3& spot, const Vec3& normal) {
  const Vec3 way = before_surface(spot, normal) - eye;
  const double distance_m = way.norm();
  return !scene.cast(eye, way / distance_m, distance_m);
}

}  // namespace

ViewRule::ViewRule(const mission::Vehicle& vehicle, double range_m, double max_incidence_rad)
    : min_elevation_rad_(vehicle.pitch_rad - vehicle.camera.vfov_rad / 2 + kAngleMargin_rad),
      max_elevation_rad_(vehicle.pitch_rad + vehicle.camera.vfov_rad / 2 - kAngleMargin_rad),
      range_m_(std::min(range_m, vehicle.camera.range_m) - kRangeMargin_m),
      least_cos_(std::cos(max_incidence_rad - kAngleMargin_rad)) {
  for (const double share : kElevationShares) {
    const double el = min_elevation_rad_ + share * (max_elevation_rad_ - min_elevation_rad_);
    for (int k = 0; k < kAzimuths; ++k) {
      const int steps = (k % 2 ? -1 : 1) * ((k + 1) / 2);  // 0, −1, 1, −2, 2 …
      const double turn = steps * 2 * std::numbers::pi / kAzimuths;
      directions_.emplace_back(std::cos(el) * std::cos(turn), std::cos(el) * std::sin(turn),
                               -std::sin(el));
    }
  }
}

ViewFinder::ViewFinder(const Scene& scene, const ReachableSpace& reachable,
                       const mission::Mission& mission)
    : scene_(scene), reachable_(reachable) {
  for (const auto& r : mission.fleet) {
    for (int i = 0; i < 64; ++i) {
      const double z = 1 - (i + 0.5) / 32, a = 2.399963 * i;  // a spiral over the sphere
      const double across = std::sqrt(1 - z * z);
      const Vec3 d(across * std::cos(a), across * std::sin(a), z);
      const auto hit = scene.cast(r.start.p, d, 100);
      if (hit && hit->from_behind) winding_tells_ = false;
    }
  }
}

bool ViewFinder::is_outside(const Vec3& point, const Vec3& normal) const {
  if (!winding_tells_) return true;
  const auto hit = scene_.cast(point + 0.005 * normal, normal, 100);
  return !hit || !hit->from_behind;
}

std::optional<Vec3> ViewFinder::look_along(const Vec3& d, const Vec3& point, const Vec3& normal,
                                           const ViewRule& rule) const {
  if (d.dot(normal) < rule.least_cos()) return std::nullopt;
  for (const double share : kDistanceShares) {
    const Vec3 eye = point + share * rule.range_m() * d;
    if (!reachable_.contains(eye)) continue;
    if (in_sight(scene_, eye, point, normal)) return eye;
    break;  // what hides the point from here hides it from further out
  }
  return std::nullopt;
}

std::optional<Vec3> ViewFinder::find(const Vec3& point, const Vec3& normal,
                                     const ViewRule& rule) const {
  const Turn turn(normal);
  for (const Vec3& local : rule.directions()) {
    if (auto eye = look_along(turn(local), point, normal, rule)) return eye;
  }
  return std::nullopt;
}

bool ViewFinder::can_see(const Vec3& point, const Vec3& normal, const ViewRule& rule,
                         std::size_t& lucky) const {
  const Turn turn(normal);
  const auto& directions = rule.directions();
  for (std::size_t i = 0; i <= directions.size(); ++i) {
    const std::size_t k = i == 0 ? lucky : i - 1;
    if (i > 0 && k == lucky) continue;
    if (!look_along(turn(directions[k]), point, normal, rule)) continue;
    lucky = k;
    return true;
  }
  return false;
}

}  // namespace muster::world
