#pragma once

#include <span>
#include <vector>

#include "common/core/bytes.h"
#include "common/map/voxel_map.h"

namespace muster::map {

/// What is said of some blocks, as bytes: BlockEncoding::kArithmetic.
///
/// Voxel by voxel, each coded by how often its like followed the seven neighbours before it: an
/// arithmetic code whose odds are learnt from the blocks themselves, anew in each code. Walls and
/// the borders of what was seen cost a fraction of a bit per voxel, and untouched layers next to
/// nothing. Equal blocks in equal order are equal bytes.
///
/// At most 256 blocks.
Bytes encode_blocks(std::span<const SaidBlock> blocks);
/// Throws BadInput for anything that `encode_blocks` does not write.
std::vector<SaidBlock> decode_blocks(ByteView bytes);

}  // namespace muster::map
