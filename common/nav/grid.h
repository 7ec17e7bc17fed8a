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

namespace detail {

constexpr int step_number(int x, int y, int z) { return (x + 1) + 3 * (y + 1) + 9 * (z + 1); }

constexpr std::array<Step, kSteps> make_steps() {
  std::array<Step, kSteps> all{};
  const auto within = [](int part, int whole) { return part == 0 || part == whole; };
  for (int n = 0; n < kSteps; ++n) {
    Step& step = all[static_cast<std::size_t>(n)];
    step.dx = n % 3 - 1, step.dy = n / 3 % 3 - 1, step.dz = n / 9 - 1;
    step.axes = (step.dx != 0) + (step.dy != 0) + (step.dz != 0);
    for (int i = 0; i < kSteps; ++i) {
      if (within(i % 3 - 1, step.dx) && within(i / 3 % 3 - 1, step.dy) &&
          within(i / 9 - 1, step.dz)) {
        step.needs |= 1u << i;
      }
    }
    step.onward = step.needs & ~(1u << kNoStep);
    if (step.axes == 0) step.onward = kAllAround & ~(1u << kNoStep);
  }
  return all;
}

inline constexpr std::array<Step, kSteps> kStepTable = make_steps();

}  // namespace detail

constexpr const std::array<Step, kSteps>& steps() { return detail::kStepTable; }

/// A voxel counted from the grid's own corner; all coordinates of voxels within the map's bounds,
/// and next to them, are ≥ 0.
struct Cell {
  int x = 0, y = 0, z = 0;
  bool operator==(const Cell&) const = default;
};

/// What a body may enter of one block: bits as in map::BlockView. Neither: unknown, maybe passable.
struct Passage {
  const std::uint64_t* traversable;
  const std::uint64_t* blocked;
};

/// The 16 bits of row (y, z) of a block.
inline std::uint32_t row_of(const std::uint64_t* plane, int y, int z) {
  return static_cast<std::uint32_t>(plane[z << 2 | y >> 2] >> ((y & 3) << 4)) & 0xFFFF;
}

/// Bits of a voxel and its 26 neighbours, bit = number of the step; `plane_of(block of a voxel)`
/// gives 64 words, never null.
template <class PlaneOf>
std::uint32_t gather(Cell c, PlaneOf plane_of) {
  const int x = c.x & 15, y = c.y & 15, z = c.z & 15;
  std::uint32_t bits = 0;
  if (x > 0 && x < 15 && y > 0 && y < 15 && z > 0 && z < 15) {  // all in one block
    const std::uint64_t* plane = plane_of(c);
    for (int i = 0; i < 9; ++i)
      bits |= (row_of(plane, y + i % 3 - 1, z + i / 3 - 1) >> (x - 1) & 7) << (3 * i);
    return bits;
  }
  for (int i = 0; i < 9; ++i) {
    const Cell at{c.x, c.y + i % 3 - 1, c.z + i / 3 - 1};
    const auto row = [&](int side) {
      return row_of(plane_of(Cell{at.x + side, at.y, at.z}), at.y & 15, at.z & 15);
    };
    std::uint32_t three = x == 0 ? (row(0) << 1 & 6) | row(-1) >> 15 : row(0) >> (x - 1) & 7;
    if (x == 15) three |= (row(1) & 1) << 2;
    bits |= three << (3 * i);
  }
  return bits;
}

/// The map's traversability, addressed without hashing: a dense table of blocks over the map's
/// bounds. Blocks are looked up in the map on first use after a change near them, and searches keep
/// their own block numbers beside them.
class Grid {
 public:
  explicit Grid(const map::VoxelMap& map);

  /// Looks again at what has changed in the map since; true when something had.
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
  static constexpr std::uint32_t kVoxels = 4096;  ///< of a block
  std::uint32_t blocks() const { return static_cast<std::uint32_t>(nx_ * ny_ * nz_); }

  bool traversable(Cell c) {
    const std::uint32_t i = local(c);
    return passage(block(c)).traversable[i >> 6] >> (i & 63) & 1;
  }
  bool blocked(Cell c) {
    const std::uint32_t i = local(c);
    return passage(block(c)).blocked[i >> 6] >> (i & 63) & 1;
  }
  /// Traversability of the voxel and its 26 neighbours, bit = number of the step.
  std::uint32_t around(Cell c) {
    return gather(c, [&](Cell n) { return passage(block(n)).traversable; });
  }
  const Passage& passage(std::uint32_t block) {
    View& v = views_[block];
    if (!v.seen) look_up(block, v);
    return v.passage;
  }
  /// Its lowest voxel.
  Cell first_of(std::uint32_t block) const { return cell_of(std::uint64_t{block} << 12); }

  const map::VoxelMap& map() const { return map_; }

 private:
  static constexpr int kMargin = map::kBlockSide;

  using Plane = std::array<std::uint64_t, 64>;
  struct View {
    Passage passage;
    std::unique_ptr<Plane> blocked;  ///< of a block that is not in the map, where it matters
    bool seen = false;
  };
  void look_up(std::uint32_t block, View& v);
  map::BlockKey block_key(std::uint32_t block) const { return map::block_of(key(first_of(block))); }

  const map::VoxelMap& map_;
  map::VoxelKey origin_;
  int nx_ = 0, ny_ = 0, nz_ = 0;
  std::vector<View> views_;
  std::uint64_t revision_ = 0, changes_ = 0;
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
    bool fresh = false;
    return at(block, fresh);
  }
  /// `fresh` becomes true when nobody asked for the block since `clear`.
  Content& at(std::uint32_t block, bool& fresh) {
    Slot& slot = slots_[block];
    if (slot.stamp != stamp_) {
      if (used_ == contents_.size()) contents_.push_back(std::make_unique<Content>());
      slot = {stamp_, static_cast<std::uint32_t>(used_++)};
      contents_[slot.index]->clear();
      fresh = true;
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
