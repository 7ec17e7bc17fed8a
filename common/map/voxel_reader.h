#pragma once

#include <limits>

#include "common/map/block.h"

namespace muster::map {

/// Reads voxel after voxel of a map and remembers the last block: neighbours are asked for one
/// after the other. Valid until the map changes.
class VoxelReader {
 public:
  explicit VoxelReader(const VoxelMap& map) : map_(map) {}

  Voxel at(VoxelKey k) {
    if (!turn_to(k)) return Voxel::kUnknown;
    const int i = local_index(k);
    if (bit(view_.free, i)) return Voxel::kFree;
    return bit(view_.occupied, i) ? Voxel::kOccupied : Voxel::kUnknown;
  }
  bool free(VoxelKey k) { return turn_to(k) && bit(view_.free, local_index(k)); }

 private:
  bool turn_to(VoxelKey k) {
    const BlockKey b{k.x >> 4, k.y >> 4, k.z >> 4};
    if (b != key_) {
      key_ = b;
      view_ = map_.view(b);
    }
    return static_cast<bool>(view_);
  }

  const VoxelMap& map_;
  BlockKey key_{std::numeric_limits<int>::max(), 0, 0};
  BlockView view_;
};

}  // namespace muster::map
