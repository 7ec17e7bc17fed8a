#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "common/core/random.h"
#include "common/map/voxel_map.h"

namespace muster::map::toy {

/// A world of a few axis-aligned boxes that a scan can be taken of.
struct World {
  struct Solid {
    Vec3 low, high;
  };
  std::vector<Solid> solids;

  /// Distance along the unit ray to the first solid; infinity when there is none.
  double cast(const Vec3& origin, const Vec3& direction) const {
    double best = std::numeric_limits<double>::infinity();
    for (const Solid& s : solids) {
      double enter = 0, leave = best;
      bool meets = true;
      for (int a = 0; a < 3 && meets; ++a) {
        if (std::abs(direction[a]) < 1e-12) {
          meets = origin[a] >= s.low[a] && origin[a] <= s.high[a];
          continue;
        }
        double t0 = (s.low[a] - origin[a]) / direction[a],
               t1 = (s.high[a] - origin[a]) / direction[a];
        if (t0 > t1) std::swap(t0, t1);
        enter = std::max(enter, t0);
        leave = std::min(leave, t1);
        meets = enter <= leave;
      }
      if (meets && enter < best) best = enter;
    }
    return best;
  }
  bool inside(const Vec3& p) const {
    return std::any_of(solids.begin(), solids.end(), [&](const Solid& s) {
      return (p.array() > s.low.array()).all() && (p.array() < s.high.array()).all();
    });
  }
};

struct Sensor {
  std::uint32_t columns = 48, rows = 31;
  double hfov_rad = std::numbers::pi / 2, vfov_rad = std::numbers::pi / 3, range_m = 5,
         pitch_rad = 0;
  double range_noise_m = 0, depth_noise = 0;  ///< as in the mission's SensingConfig

  static Sensor noisy() {
    Sensor s;
    s.range_noise_m = 0.02;
    s.depth_noise = 0.05;
    return s;
  }
};

/// A scan that owns its ranges.
struct Shot {
  RangeScan scan;
  std::vector<std::uint16_t> range_mm;

  VoxelMap::Integrated into(VoxelMap& map, std::span<const Sphere> mates = {}) {
    scan.range_mm = range_mm;
    return map.integrate(scan, mates);
  }
};

inline Shot shoot(const World& world, const Pose& pose, const Sensor& sensor = {},
                  double time_s = 0, Random* random = nullptr) {
  Shot shot;
  for (std::uint32_t r = 0; r < sensor.rows; ++r) {
    for (std::uint32_t c = 0; c < sensor.columns; ++c) {
      const double az = sensor.hfov_rad * (0.5 - (c + 0.5) / sensor.columns);
      const double el = sensor.vfov_rad * ((r + 0.5) / sensor.rows - 0.5);
      double d = world.cast(pose.p, ray_direction(pose.yaw_rad, sensor.pitch_rad, az, el));
      if (random && std::isfinite(d)) {
        d *= 1 + std::clamp(random->normal() / 3, -1.0, 1.0) * sensor.depth_noise;
        d += random->uniform(-sensor.range_noise_m, sensor.range_noise_m);
      }
      const bool seen = d <= sensor.range_m;
      shot.range_mm.push_back(seen ? static_cast<std::uint16_t>(std::max(1L, std::lround(d * 1000)))
                                   : 0);
    }
  }
  shot.scan.time = SimTime::from_s(time_s);
  shot.scan.sensor = pose;
  shot.scan.pitch_rad = sensor.pitch_rad;
  shot.scan.columns = sensor.columns;
  shot.scan.rows = sensor.rows;
  shot.scan.hfov_rad = sensor.hfov_rad;
  shot.scan.vfov_rad = sensor.vfov_rad;
  shot.scan.range_m = sensor.range_m;
  return shot;
}

inline VoxelMap::Integrated see(VoxelMap& map, const World& world, const Pose& pose,
                                const Sensor& sensor = {}, double time_s = 0,
                                Random* random = nullptr, std::span<const Sphere> mates = {}) {
  return shoot(world, pose, sensor, time_s, random).into(map, mates);
}

inline MapConfig config() {
  MapConfig c;
  c.bounds = Box::from_corners({-10, -10, -1}, {10, 10, 8});
  return c;
}

/// Every voxel around the bounds of `config()`.
template <class Visit>
void for_each_voxel(Visit visit) {
  for (int z = -7; z < 43; ++z) {
    for (int y = -53; y < 53; ++y) {
      for (int x = -53; x < 53; ++x) visit(VoxelKey{x, y, z});
    }
  }
}

inline std::vector<Voxel> states(const VoxelMap& m) {
  std::vector<Voxel> all;
  for_each_voxel([&](VoxelKey k) { all.push_back(m.at(k)); });
  return all;
}

/// Noisy scans from random poses.
inline void fly_randomly(VoxelMap& m, const World& world, int scans, std::uint64_t seed) {
  Random random(seed, RobotId{1}, "flight");
  for (int i = 0; i < scans; ++i) {
    const Vec3 p(random.uniform(-4, 2), random.uniform(-4, 4), random.uniform(0.5, 3));
    const double yaw = random.uniform(-3, 3);
    if (!world.inside(p)) see(m, world, {p, yaw}, Sensor::noisy(), 0.5 * i, &random);
  }
}

}  // namespace muster::map::toy
