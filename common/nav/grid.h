#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/map/voxel_map.h"

namespace muster::nav {

/// A step to one of the 26 neighbours, or none: number (dx+1) + 3(dy+1) + 9(dz+1).
struct Step {
  int dx = 0, dy = 0, dz = 0;
  int axes = 0;  ///< how many coordinates change: 1, 2 or 3
  std::uint32_t needs =
      0;  ///< all voxels of the box that the step spans, as neighbour bits: no corner is cut
  std::uint32_t onward =
      0;  ///< steps worth trying after this one where everything around is free (see Flood)
};
inline constexpr int kSteps = 27, kNoStep = 13;
inline constexpr std::uint32_t kAllAround = (1u << kSteps) - 1;
const std::array<Step, kSteps>& steps();

/// A voxel counted from the grid's own corner; all coordinates of voxels within the map's bounds,
/// and next to them, are ≥ 0.
struct Cell {
  int x = 0, y = 0, z = 0;
  bool operator==(const Cell&) const = default;
};

/// The map's traversability, addressed without hashing: a dense table of blocks over the map's
/// bounds. Blocks are looked up in the map on first use after a change, and searches keep their own
/// block numbers beside them.
class Grid {
 public:
  explicit Grid(const map::VoxelMap& map);

  /// Forgets the views when the map has changed since; true when it had.
  bool refresh();

  Cell cell(map::VoxelKey k) const { return {k.x - origin_.x, k.y - origin_.y, k.z - origin_.z}; }
  map::VoxelKey key(Cell c) const { return {c.x + origin_.x, c.y + origin_.y, c.z + origin_.z}; }
  Vec3 center(Cell c) const { return map_.center(key(c)); }
  /// Within the table, with a block to spare on each side.
  bool holds(Cell c) const {
    return c.x >= kMargin && c.y >= kMargin && c.z >= kMargin && c.x < (nx_ << 4) - kMargin &&
           c.y < (ny_ << 4) - kMargin && c.z < (nz_ << 4) - kMargin;
  }

  std::uint32_t block(Cell c) const {
    return static_cast<std::uint32_t>((c.x >> 4) + nx_ * ((c.y >> 4) + ny_ * (c.z >> 4)));
  }
  static std::uint32_t local(Cell c) {
    return static_cast<std::uint32_t>((c.x & 15) | (c.y & 15) << 4 | (c.z & 15) << 8);
  }
  std::uint64_t id(Cell c) const { return std::uint64_t{block(c)} << 12 | local(c); }
  Cell cell_of(std::uint64_t id) const;
  std::uint32_t blocks() const { return static_cast<std::uint32_t>(nx_ * ny_ * nz_); }

  bool traversable(Cell c) {
    const std::uint64_t* words = view(block(c));
    const std::uint32_t i = local(c);
    return words && (words[i >> 6] >> (i & 63) & 1);
  }
  /// Traversability of the voxel and its 26 neighbours, bit = number of the step.
  std::uint32_t around(Cell c);

  const map::VoxelMap& map() const { return map_; }

 private:
  static constexpr int kMargin = map::kBlockSide;

  struct View {
    const std::uint64_t* words = nullptr;
    std::uint32_t stamp = 0;
  };
  const std::uint64_t* view(std::uint32_t block) {
    View& v = views_[block];
    if (v.stamp != stamp_) look_up(block, v);
    return v.words;
  }
  void look_up(std::uint32_t block, View& v);
  std::uint32_t three(Cell c);  ///< bits of the voxels x−1 … x+1

  const map::VoxelMap& map_;
  map::VoxelKey origin_;
  int nx_ = 0, ny_ = 0, nz_ = 0;
  std::vector<View> views_;
  std::uint32_t stamp_ = 1;
  std::uint64_t revision_ = 0;
};

/// Arrays of a search, one per block that it touches, kept from search to search: a search costs
/// what it visits, not what the map holds.
template <class Content>
class BlockPool {
 public:
  explicit BlockPool(std::uint32_t blocks) : slots_(blocks) {}

  void clear() {
    used_ = 0;
    if (++stamp_ == 0) {
      slots_.assign(slots_.size(), {});
      stamp_ = 1;
    }
  }
  Content& at(std::uint32_t block) {
    Slot& slot = slots_[block];
    if (slot.stamp != stamp_) {
      if (used_ == contents_.size()) contents_.push_back(std::make_unique<Content>());
      slot = {stamp_, static_cast<std::uint32_t>(used_++)};
      contents_[slot.index]->clear();
    }
    return *contents_[slot.index];
  }
  const Content* find(std::uint32_t block) const {
    const Slot& slot = slots_[block];
    return slot.stamp == stamp_ ? contents_[slot.index].get() : nullptr;
  }

 private:
  struct Slot {
    std::uint32_t stamp = 0, index = 0;
  };
  std::vector<Slot> slots_;
  std::vector<std::unique_ptr<Content>> contents_;
  std::size_t used_ = 0;
  std::uint32_t stamp_ = 1;
};

}  // namespace muster::nav
