#pragma once

#include "common/map/block.h"

namespace muster::map {

/// The six directions to a voxel's face neighbours; direction i and i ^ 1 are opposite.
inline constexpr VoxelKey kFaces[6] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                       {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};

/// For every voxel the bit of its neighbour in direction `face`, taken from the block beyond
/// (`next`) at the edge.
Plane shifted(const Plane& own, const Plane& next, int face);

template <class Visit>
void for_each_bit(const Plane& plane, Visit visit) {
  for (std::size_t w = 0; w < plane.size(); ++w) {
    for (std::uint64_t bits = plane[w]; bits != 0; bits &= bits - 1) {
      visit(static_cast<int>(w) * 64 + __builtin_ctzll(bits));
    }
  }
}

}  // namespace muster::map
