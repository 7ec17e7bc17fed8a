#pragma once

#include <cstdint>
#include <vector>

#include "common/map/planes.h"

namespace muster::map {

/// Connected voxels that want one viewpoint.
struct CellCluster {
  std::vector<VoxelKey> cells;
  std::uint64_t fingerprint = 0;  ///< of the cells
  double group_m2 = 0;            ///< of the whole connected group that this is a part of
};

/// Groups marked voxels of a fixed set of blocks into clusters, anew only where marks changed.
///
/// A block's marks fall into *pieces* (26-connected, halved until they are small enough). Pieces
/// that touch, also across blocks, form a group; within a group neighbouring pieces are joined
/// while the result stays below the largest extent.
class CellClusters {
 public:
  /// `neighbour[26]` per slot: slot number of the block at [dx+1 + 3(dy+1) + 9(dz+1)], −1: none.
  using Neighbours = std::vector<std::array<int, 27>>;
  CellClusters(const std::vector<BlockKey>& blocks, const Neighbours& neighbours,
               double resolution_m, double max_extent_m);

  void set(std::size_t slot, const Plane& marks);
  const Plane& marks(std::size_t slot) const { return slots_[slot].marks; }
  bool changed() const { return changed_; }
  std::vector<CellCluster> clusters();

 private:
  struct Piece {
    std::vector<std::uint16_t> cells;
    std::uint32_t component = 0;
    VoxelKey low, high;
  };
  struct Link {
    std::uint32_t piece, other_slot, other_piece;
  };
  struct Slot {
    BlockKey key;
    Plane marks{};
    std::vector<Piece> pieces;
    std::vector<std::uint16_t> label;  ///< per voxel: its piece + 1
    std::vector<Link> links;           ///< to later pieces of its own and to other blocks
    bool stale_links = false;
  };

  void cut_into_pieces(Slot& slot);
  void add_piece(Slot& slot, std::vector<std::uint16_t> cells, std::uint32_t component);
  void relink(std::size_t index);

  std::vector<Slot> slots_;
  const Neighbours& neighbours_;
  double cell_m2_;
  int max_cells_;
  bool changed_ = false;
};

}  // namespace muster::map
