#pragma once

#include "common/core/bytes.h"
#include "common/map/voxel_map.h"

namespace muster::robot {

/// All that `map` knows in one piece: 2 bits a voxel, in blocks of 16³, compressed as a whole
/// (zstd). Nobody sends it; it is what the exchange of single blocks is compared with, and smaller
/// than the blocks one by one would be.
Bytes whole_map(const map::VoxelMap& map);

}  // namespace muster::robot
