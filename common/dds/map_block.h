#pragma once

#include <span>
#include <vector>

#include "common/map/voxel_map.h"
#include "common/mission/messages.h"

namespace muster::dds {

/// At most 256 blocks.
mission::MapBlock map_block(std::span<const map::SaidBlock> said, double resolution_m);

/// What a map record says. Throws BadInput when its encoding is not ours, its voxels are not of
/// `resolution_m`, or its bytes are no blocks.
std::vector<map::SaidBlock> said_blocks(const mission::MapBlock& record, double resolution_m);

}  // namespace muster::dds
