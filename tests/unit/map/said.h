#pragma once

#include <vector>

#include "common/map/block.h"

namespace muster::map {

/// Words on a whole block, x fastest, then y, then z; nothing on what is unknown.
inline SaidBlock said(BlockKey key, const std::vector<Voxel>& voxels) {
  SaidBlock block{key, {}};
  for (int i = 0; i < kBlockVoxels; ++i) {
    put(block.said.free, i, voxels.at(static_cast<std::size_t>(i)) == Voxel::kFree);
    put(block.said.occupied, i, voxels.at(static_cast<std::size_t>(i)) == Voxel::kOccupied);
  }
  return block;
}
inline SaidBlock said(BlockKey key, Voxel everywhere) {
  return said(key, std::vector<Voxel>(kBlockVoxels, everywhere));
}

}  // namespace muster::map
