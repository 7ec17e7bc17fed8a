#include "common/map/watch.h"

#include <bit>
#include <cmath>

namespace muster::map {

Watch::Watch(const Box& box, const MapConfig& config)
    : voxel_m3_(std::pow(config.resolution_m, 3)) {
  const double side = config.resolution_m * kBlockSide;
  const Vec3 low = box.low().cwiseMax(config.bounds.low()),
             high = box.high().cwiseMin(config.bounds.high());
  const auto index = [&](double v) { return static_cast<int>(std::floor(v / side)); };
  for (int z = index(low.z()); z <= index(high.z()); ++z) {
    for (int y = index(low.y()); y <= index(high.y()); ++y) {
      for (int x = index(low.x()); x <= index(high.x()); ++x) {
        Plane inside = voxels_inside({x, y, z}, config.resolution_m, box);
        const Plane within = voxels_inside({x, y, z}, config.resolution_m, config.bounds);
        for (std::size_t w = 0; w < inside.size(); ++w) inside[w] &= within[w];
        const int n = count(inside);
        if (n == 0) continue;
        voxels_ += n;
        parts_.emplace(pack({x, y, z}), Part{inside, 0});
      }
    }
  }
}

double Watch::known_m3(const BlockStore& blocks) {
  for (const BlockKey& b : blocks.changes(cursor_)) {
    const auto it = parts_.find(pack(b));
    if (it == parts_.end()) continue;
    const States& s = blocks.find(b)->merged;
    int known = 0;
    for (std::size_t w = 0; w < 64; ++w)
      known += std::popcount((s.free[w] | s.occupied[w]) & it->second.inside[w]);
    known_ += known - it->second.known;
    it->second.known = known;
  }
  return static_cast<double>(known_) * voxel_m3_;
}

}  // namespace muster::map
