#include "common/robot/seen_bodies.h"

#include <algorithm>
#include <cmath>

namespace muster::robot {
namespace {

constexpr double kLife_s = 15.0;
constexpr double kJustSeen_s = 1.0;
constexpr double kAboveGround_m = 0.9;  // of a return, from a body that stands on nothing
constexpr double kSamePoint_m = 0.2;
constexpr double kSize_m = 0.4;            // returns this near each other are one body's
constexpr double kFieldMargin_rad = 0.05;  // a body at the edge of the view may be half in it
constexpr double kLidarPlane_m = 0.3;
constexpr double kRadius_m = 0.3;
constexpr double kBelow_m = 0.6;  // a return this near a landing place, seen from above, takes it

}  // namespace

bool in_view(const map::RangeScan& scan, const Vec3& p) {
  const Vec3 d = p - scan.sensor.p;
  if (d.norm() > scan.range_m) return false;
  const double bearing = std::abs(wrap_angle(std::atan2(d.y(), d.x()) - scan.sensor.yaw_rad));
  const double above = std::abs(std::atan2(d.z(), d.head<2>().norm()) - scan.pitch_rad);
  const bool lidar = scan.vfov_rad <= 0;
  return bearing < scan.hfov_rad / 2 - kFieldMargin_rad &&
         (lidar ? std::abs(d.z()) < kLidarPlane_m : above < scan.vfov_rad / 2 - kFieldMargin_rad);
}

void SeenBodies::see(SimTime now, const std::vector<Vec3>& unexplained) {
  const SimTime until = now + Duration::from_s(kLife_s);
  for (const Vec3& p : unexplained) {
    const auto near = std::find_if(obstacles_.begin(), obstacles_.end(), [&](const Obstacle& o) {
      return (o.p - p).norm() < kSamePoint_m;
    });
    if (near != obstacles_.end())
      *near = {p, until};
    else
      obstacles_.push_back({p, until});
  }
}

void SeenBodies::see_through(const map::VoxelMap& map, const map::RangeScan& scan,
                             const std::vector<Vec3>& unexplained) {
  std::erase_if(obstacles_, [&](const Obstacle& o) {
    const bool seen = std::any_of(unexplained.begin(), unexplained.end(),
                                  [&](const Vec3& p) { return (p - o.p).norm() < kSize_m; });
    return !seen && in_view(scan, o.p) && map.line_of_sight(scan.sensor.p, o.p, true);
  });
}

void SeenBodies::forget(SimTime now) {
  std::erase_if(obstacles_, [&](const Obstacle& o) { return o.until < now; });
  spheres_.clear();
  for (const Obstacle& o : obstacles_) spheres_.push_back({o.p, kRadius_m});
}

bool SeenBodies::in_the_air(const map::VoxelMap& map, const map::Sphere& around,
                            SimTime now) const {
  const double edge_m = map.config().resolution_m;
  return std::any_of(obstacles_.begin(), obstacles_.end(), [&](const Obstacle& o) {
    if ((o.until - now).s() < kLife_s - kJustSeen_s) return false;
    if ((o.p - around.center).norm() > around.radius_m) return false;
    for (int i = 1; i * edge_m <= kAboveGround_m; ++i) {
      if (map.at(Vec3(o.p - i * edge_m * Vec3::UnitZ())) != map::Voxel::kFree) return false;
    }
    return true;
  });
}

bool SeenBodies::below(const Vec3& p, double radius_m) const {
  return std::any_of(obstacles_.begin(), obstacles_.end(), [&](const Obstacle& o) {
    return o.p.z() < p.z() + radius_m && (o.p - p).head<2>().norm() < kBelow_m;
  });
}

}  // namespace muster::robot
