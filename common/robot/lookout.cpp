#include "common/robot/lookout.h"

#include <algorithm>
#include <cmath>

#include "common/robot/seen_bodies.h"

namespace muster::robot {
namespace {

constexpr double kSeenFor_s = 60;
constexpr double kStep_m = 0.3;
constexpr double kMargin_m = 0.15;

/// A body of `radius_m` that stands on something may touch one of the same size at `p`.
bool standable(const map::VoxelMap& map, const Vec3& p, double radius_m) {
  const double edge_m = map.config().resolution_m;
  const double around_m = 2 * radius_m + kMargin_m, below_m = 3 * radius_m + kMargin_m;
  const int body = static_cast<int>(std::ceil(2 * radius_m / edge_m));  // voxels
  const double above_m = radius_m + body * edge_m;
  const int columns = static_cast<int>(2 * around_m / edge_m);
  const int down = static_cast<int>((above_m + below_m) / edge_m);
  for (int ix = 0; ix <= columns; ++ix) {
    for (int iy = 0; iy <= columns; ++iy) {
      int room = 0;  // above the voxel, from the top down
      for (int iz = 0; iz <= down; ++iz) {
        const Vec3 off(ix * edge_m - around_m, iy * edge_m - around_m, above_m - iz * edge_m);
        if (map.at(Vec3(p + off)) == map::Voxel::kFree) {
          ++room;
          continue;
        }
        if (room >= body && off.z() <= radius_m) return true;
        room = 0;
      }
    }
  }
  return false;
}

}  // namespace

void Lookout::looked(SimTime now, const map::RangeScan& scan) {
  std::erase_if(glances_, [&](const map::RangeScan& g) { return (now - g.time).s() > kSeenFor_s; });
  glances_.push_back(scan);
  glances_.back().time = now;
  glances_.back().range_mm = {};
}

bool Lookout::seen(const Vec3& p, const map::VoxelMap& map, SimTime now) const {
  return std::any_of(glances_.rbegin(), glances_.rend(), [&](const map::RangeScan& g) {
    return (now - g.time).s() <= kSeenFor_s && in_view(g, p) &&
           map.line_of_sight(g.sensor.p, p, true);
  });
}

bool Lookout::clear(const nav::Path& path, const map::VoxelMap& map, SimTime now,
                    double radius_m) const {
  const Vec3& here = path.points.front();
  for (std::size_t i = 1; i < path.points.size(); ++i) {
    const Vec3 from = path.points[i - 1], leg = path.points[i] - from;
    const int steps = std::max(1, static_cast<int>(std::ceil(leg.norm() / kStep_m)));
    for (int k = 1; k <= steps; ++k) {
      const Vec3 p = from + leg * k / steps;
      if ((p - here).norm() < 2 * radius_m || seen(p, map, now)) continue;
      if (standable(map, p, radius_m)) return false;
    }
  }
  return true;
}

}  // namespace muster::robot
