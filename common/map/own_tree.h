#pragma once

#include <octomap/OcTree.h>

#include <span>

#include "common/map/block.h"

namespace muster::map {

/// Makes the part of `tree` that block `b` covers equal to `evidence` (kNoEvidence: unknown). Parts
/// of one value become one node, as OctoMap's pruning would. A block is exactly one node of the
/// tree four levels above the leaves, so this descends once for 4096 voxels where `updateNode`
/// descends 16 levels for each.
void write_block(octomap::OcTree& tree, BlockKey b,
                 std::span<const Evidence, kBlockVoxels> evidence);

}  // namespace muster::map
