#pragma once

#include <functional>

#include "tests/unit/map/said.h"
#include "tests/unit/robot/fixtures.h"

namespace muster::agent {

/// Makes everything inside the blocks around `low`…`high` known to `k`, as if a teammate had sent
/// it: occupied where `solid` says so, free elsewhere.
inline void reveal(robot::Knowledge& k, const Vec3& low, const Vec3& high,
                   const std::function<bool(const Vec3&)>& solid) {
  const auto first = map::block_of(k.map().key(low)), last = map::block_of(k.map().key(high));
  for (int z = first.z; z <= last.z; ++z) {
    for (int y = first.y; y <= last.y; ++y) {
      for (int x = first.x; x <= last.x; ++x) {
        std::vector<map::Voxel> voxels;
        for (int i = 0; i < 16 * 16 * 16; ++i) {
          const map::VoxelKey v{16 * x + i % 16, 16 * y + i / 16 % 16, 16 * z + i / 256};
          voxels.push_back(solid(k.map().center(v)) ? map::Voxel::kOccupied : map::Voxel::kFree);
        }
        k.map().merge(RobotId{1}, map::said({x, y, z}, voxels));
      }
    }
  }
}

inline mission::Area area_at(const Vec3& position, const Vec3& sighted_from) {
  mission::Area a;
  a.position = position;
  a.sighted_from.p = sighted_from;
  a.normal = (sighted_from - position).normalized();
  a.sigma_m = 0.07f;
  a.unexplained = 2;
  a.region = RegionId{0};
  return a;
}

inline void be_at(robot::Knowledge& k, double t_s, const Vec3& p) {
  k.begin(SimTime::from_s(t_s));
  mission::Odometry o;
  o.time = k.now();
  o.pose.p = p;
  k.observe(o);
}

}  // namespace muster::agent
