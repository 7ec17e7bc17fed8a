#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>

#include "common/map/voxel_map.h"

namespace muster::map {

inline constexpr int kBlockVoxels = kBlockSide * kBlockSide * kBlockSide;

inline int local_index(VoxelKey k) { return (k.x & 15) | (k.y & 15) << 4 | (k.z & 15) << 8; }
inline VoxelKey voxel_in(BlockKey b, int index) {
  return {b.x * kBlockSide + (index & 15), b.y * kBlockSide + (index >> 4 & 15),
          b.z * kBlockSide + (index >> 8)};
}
inline bool bit(const std::uint64_t* plane, int i) { return plane[i >> 6] >> (i & 63) & 1; }
inline bool bit(const Plane& plane, int i) { return bit(plane.data(), i); }
inline void put(Plane& plane, int i, bool value) {
  const std::uint64_t mask = std::uint64_t{1} << (i & 63);
  if (value) {
    plane[static_cast<std::size_t>(i >> 6)] |= mask;
  } else {
    plane[static_cast<std::size_t>(i >> 6)] &= ~mask;
  }
}
int count(const Plane& plane);
/// The 16 bits of row (y, z).
inline std::uint32_t row(const std::uint64_t* plane, int y, int z) {
  return static_cast<std::uint32_t>(plane[z << 2 | y >> 2] >> ((y & 3) << 4)) & 0xFFFFu;
}

/// The voxels of a block whose centres lie in `box`.
Plane voxels_inside(BlockKey b, double resolution_m, const Box& box);

/// Own log-odds in steps of 0.05, a copy of what the OcTree holds: it tells in one look whether an
/// observation changes anything.
using Evidence = std::int8_t;
inline constexpr Evidence kNoEvidence = -128;
inline constexpr float kEvidenceStep = 0.05f;

struct OwnBlock {
  OwnBlock() { evidence.fill(kNoEvidence); }
  std::array<Evidence, kBlockVoxels> evidence;
  States states;
};

/// All that is known of 16³ voxels. The planes of the merged map lie side by side; own evidence and
/// others' words are allocated only where they exist.
struct Block {
  explicit Block(BlockKey k) : key(k) {}
  BlockKey key;
  States merged;
  Plane traversable{}, blocked{};
  std::array<Block*, 27>
      around{};  ///< [dx+1 + 3(dy+1) + 9(dz+1)]; null: not allocated; [13] is itself
  std::unique_ptr<OwnBlock> own;
  std::map<RobotId, std::unique_ptr<States>> others;  ///< the last that each said of each voxel
  std::unique_ptr<States> told;                       ///< the same of this robot's own
  std::unique_ptr<Plane> inside;                      ///< voxels that are mapped; null: all of them
  std::unique_ptr<Plane> fence;  ///< voxels within the bounds: where a body may be; null: all
  std::uint64_t changed_at = 0, own_changed_at = 0;
  std::uint64_t touched_scan = 0;  ///< last scan that changed own evidence
  std::uint32_t border_changed =
      0;  ///< bit i: around[i] is near a voxel that changed in this operation
  bool changed = false, own_changed = false, stale = false, in_tree_queue = false;

  bool mapped(int i) const { return !inside || bit(*inside, i); }
};

}  // namespace muster::map
