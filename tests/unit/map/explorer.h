#pragma once

#include <ctime>
#include <vector>

#include "common/map/targets.h"
#include "tests/unit/map/toy_world.h"

namespace muster::map::toy {

/// Traversable voxels connected to a start, with path lengths (6-neighbourhood).
class Flood {
 public:
  Flood(const VoxelMap& map, const Vec3& start) : map_(map), steps_(kSide * kSide * kSide, -1) {
    std::vector<VoxelKey> queue;
    const VoxelKey s = map.key(start);
    for (int i = 0; i < 27 && queue.empty(); ++i) {
      const int d = (i + 13) % 27;
      const VoxelKey k{s.x + d % 3 - 1, s.y + d / 3 % 3 - 1, s.z + d / 9 - 1};
      if (map.traversable(k)) queue.push_back(k);
    }
    for (const VoxelKey& k : queue) steps_[index(k)] = 0;
    for (std::size_t head = 0; head < queue.size(); ++head) {
      const VoxelKey k = queue[head];
      for (const VoxelKey& d : kSteps) {
        const VoxelKey next{k.x + d.x, k.y + d.y, k.z + d.z};
        if (steps_[index(next)] >= 0 || !map.traversable(next)) continue;
        steps_[index(next)] = steps_[index(k)] + 1;
        queue.push_back(next);
      }
    }
  }
  bool reached(const Vec3& p) const { return steps_[index(map_.key(p))] >= 0; }
  double length_m(const Vec3& p) const {
    return reached(p) ? 0.2 * steps_[index(map_.key(p))] : 1e9;
  }

 private:
  static constexpr int kSide = 110;  // ± 11 m
  static constexpr VoxelKey kSteps[6] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                         {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};
  static std::size_t index(VoxelKey k) {
    return static_cast<std::size_t>(k.x + 55 + kSide * (k.y + 55 + kSide * (k.z + 55)));
  }
  const VoxelMap& map_;
  std::vector<int> steps_;
};

struct Explored {
  int views = 0;
  double length_m = 0;
  double update_ms = 0, worst_update_ms = 0;  ///< of CPU, for people
  int updates = 0;
  bool done = false;
  std::vector<Viewpoint> path;
};

/// Goes to the cheapest viewpoint again and again and scans there; the detector looks once at every
/// stop.
inline Explored explore(const World& world, VoxelMap& map, Targets& targets, Pose start,
                        const Sensor& sensor, Random* random, int most_views) {
  Explored result;
  map.insert_free_ball(start.p, 1.5);
  Pose at = start;
  double time_s = 0;
  const auto stop = [&] {
    for (int i = 0; i < 2; ++i) {
      see(map, world, at, sensor, time_s, random);
      targets.scanned(at);
      time_s += 0.5;
    }
    targets.looked(at, sensor.pitch_rad);
  };
  stop();
  while (result.views < most_views) {
    const Flood flood(map, at.p);
    for (int i = 0; i < 20; ++i) {
      const auto begin = std::clock();
      targets.update([&](const Vec3& p) { return flood.reached(p); });
      const double ms = 1e3 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
      result.update_ms += ms;
      result.worst_update_ms = std::max(result.worst_update_ms, ms);
      ++result.updates;
      if (targets.done() || !targets.viewpoints().empty()) break;
    }
    if (targets.done()) break;
    const Viewpoint* best = nullptr;
    double best_cost = 1e18;
    for (const Viewpoint& v : targets.viewpoints()) {
      const double turn = std::abs(wrap_angle(v.pose.yaw_rad - at.yaw_rad));
      const double cost =
          (flood.length_m(v.pose.p) / 2 + turn / 1.5 + 0.5) / std::sqrt(v.gain + 0.2);
      if (cost < best_cost) {
        best = &v;
        best_cost = cost;
      }
    }
    if (!best) continue;
    result.length_m += flood.length_m(best->pose.p);
    at = best->pose;
    result.path.push_back(*best);
    ++result.views;
    stop();
  }
  result.done = targets.done();
  return result;
}

}  // namespace muster::map::toy
