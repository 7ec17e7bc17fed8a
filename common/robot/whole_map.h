#pragma once

#include <map>
#include <set>
#include <utility>

#include "common/map/voxel_map.h"
#include "common/mission/process.h"

namespace muster::robot {

/// What it would cost to send all that a map knows at once, as nobody here does: the yardstick for
/// what the exchange of news costs. Only what changed since the last time is measured anew.
class WholeMap {
 public:
  mission::WholeMapBytes bytes(const map::VoxelMap& map);

 private:
  struct Piece {
    std::set<map::BlockKey> blocks;
    std::uint64_t bytes = 0;
  };
  void measure_octree(const map::BlockKey& key, const map::BlockView& block);
  void measure_piece(const map::VoxelMap& map, Piece& piece);

  std::uint64_t cursor_ = 0;
  mission::WholeMapBytes sum_;
  std::map<map::BlockKey, Piece> pieces_;          // of 4³ blocks
  std::map<map::BlockKey, std::uint64_t> inner_;   // the octree's inner nodes within a block
  std::set<std::pair<int, map::BlockKey>> above_;  // and those above blocks, by level
};

}  // namespace muster::robot
