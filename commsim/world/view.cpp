#include "commsim/world/view.h"

#include <algorithm>
#include <cmath>

namespace muster::world {
namespace {

constexpr double kRangeMargin_m = 0.2;
constexpr double kAngleMargin_rad = 0.035;  // 2°
constexpr double kDistanceShares[] = {0.45, 0.7, 0.3, 0.95, 0.17};
constexpr double kElevationShares[] = {0.5, 0.1, 0.9, 0.3, 0.7, 0.0, 1.0};
constexpr int kAzimuths = 16;

}  // namespace

ViewRule ViewRule::of_camera(const mission::Vehicle& vehicle, double range_m,
                             double max_incidence_rad) {
  const double half = vehicle.camera.vfov_rad / 2 - kAngleMargin_rad;
  return {vehicle.pitch_rad - half, vehicle.pitch_rad + half,
          std::min(range_m, vehicle.camera.range_m) - kRangeMargin_m,
          max_incidence_rad - kAngleMargin_rad};
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

std::optional<Vec3> ViewFinder::find(const Vec3& point, const Vec3& normal,
                                     const ViewRule& rule) const {
  const double least_cos = std::cos(rule.max_incidence_rad);
  const double flat = std::hypot(normal.x(), normal.y());
  const double facing_rad = flat > 1e-9 ? std::atan2(normal.y(), normal.x()) : 0;
  for (const double share : kDistanceShares) {
    const double distance_m = share * rule.range_m;
    for (const double e : kElevationShares) {
      const double elevation =
          rule.min_elevation_rad + e * (rule.max_elevation_rad - rule.min_elevation_rad);
      for (int k = 0; k < kAzimuths; ++k) {
        // Straight ahead first, then further to either side.
        const double turn = (k % 2 ? -1 : 1) * ((k + 1) / 2) * 2 * std::numbers::pi / kAzimuths;
        const double azimuth = facing_rad + turn;
        const Vec3 d(std::cos(elevation) * std::cos(azimuth),
                     std::cos(elevation) * std::sin(azimuth), -std::sin(elevation));
        if (d.dot(normal) < least_cos) continue;
        const Vec3 eye = point + distance_m * d;
        if (reachable_.contains(eye) && scene_.line_of_sight(eye, point)) return eye;
      }
    }
  }
  return std::nullopt;
}

}  // namespace muster::world
