#pragma once

#include <map>
#include <vector>

#include "common/core/random.h"
#include "common/map/voxel_map.h"
#include "tests/unit/map/said.h"

namespace muster::test {

/// Uniform in {0 … n−1}; n > 0.
inline int below(Random& random, int n) {
  return static_cast<int>(random.below(static_cast<std::uint64_t>(n)));
}

/// A map that is known by decree, as if another robot had sent its blocks: a box of free voxels,
/// some of them occupied, unknown around.
class KnownMap {
 public:
  /// Voxels low … high−1 per axis are free.
  KnownMap(map::VoxelKey low, map::VoxelKey high, map::MapConfig config = {}) : config_(config) {
    for (int z = low.z; z < high.z; ++z) {
      for (int y = low.y; y < high.y; ++y) {
        for (int x = low.x; x < high.x; ++x) set({x, y, z}, map::Voxel::kFree);
      }
    }
  }

  void set(map::VoxelKey k, map::Voxel voxel) {
    auto& block = blocks_[map::block_of(k)];
    if (block.empty()) block.assign(4096, map::Voxel::kUnknown);
    block[static_cast<std::size_t>((k.x & 15) | (k.y & 15) << 4 | (k.z & 15) << 8)] = voxel;
    map_.reset();
  }
  void occupy(map::VoxelKey k) { set(k, map::Voxel::kOccupied); }

  /// Built on demand from what was set.
  map::VoxelMap& map() {
    if (!map_) {
      if (config_.bounds.size.norm() == 0) {
        config_.bounds = Box::from_corners(Vec3(-40, -40, -10), Vec3(60, 60, 30));
      }
      map_ = std::make_unique<map::VoxelMap>(config_);
      for (const auto& [key, voxels] : blocks_) {
        map_->merge(RobotId{99}, map::said(key, voxels));
      }
    }
    return *map_;
  }

 private:
  map::MapConfig config_;
  std::map<map::BlockKey, std::vector<map::Voxel>> blocks_;
  std::unique_ptr<map::VoxelMap> map_;
};

}  // namespace muster::test
