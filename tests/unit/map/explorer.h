#pragma once

#include <deque>
#include <map>

#include "common/map/targets.h"
#include "tests/unit/map/toy_world.h"

namespace muster::map::toy {

/// Traversable voxels connected to a start, with path lengths (6-neighbourhood).
class Flood {
 public:
  Flood(const VoxelMap& map, const Vec3& start) : map_(map) {
    std::deque<VoxelKey> queue;
    const VoxelKey s = map.key(start);
    for (int i = 0; i < 27 && queue.empty(); ++i) {
      const VoxelKey k{s.x + (i + 13) % 27 % 3 - 1, s.y + (i + 13) % 27 / 3 % 3 - 1,
                       s.z + (i + 13) % 27 / 9 - 1};
      if (map.traversable(k)) queue.push_back(k);
    }
    for (const VoxelKey& k : queue) steps_[k] = 0;
    while (!queue.empty()) {
      const VoxelKey k = queue.front();
      queue.pop_front();
      const int n = steps_[k];
      for (const VoxelKey& d :
           {VoxelKey{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}) {
        const VoxelKey next{k.x + d.x, k.y + d.y, k.z + d.z};
        if (map.traversable(next) && steps_.emplace(next, n + 1).second) queue.push_back(next);
      }
    }
  }
  bool reached(const Vec3& p) const { return steps_.contains(map_.key(p)); }
  double length_m(const Vec3& p) const {
    const auto it = steps_.find(map_.key(p));
    return it == steps_.end() ? 1e9 : 0.2 * it->second;
  }

 private:
  const VoxelMap& map_;
  std::map<VoxelKey, int> steps_;
};

struct Explored {
  int views = 0;
  double length_m = 0;
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
      targets.update([&](const Vec3& p) { return flood.reached(p); });
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
