#include "common/map/block_store.h"

#include <algorithm>
#include <bit>

namespace muster::map {
namespace {

/// Which of the 27 blocks around are within `radius` voxels of voxel (x, y, z): bit dx+1 + 3(dy+1)
/// + 9(dz+1).
std::uint32_t near_blocks(int i, int radius) {
  const int c[3] = {i & 15, i >> 4 & 15, i >> 8};
  std::uint32_t mask = 0;
  int low[3], high[3];
  for (int a = 0; a < 3; ++a) {
    low[a] = c[a] < radius ? -1 : 0;
    high[a] = c[a] >= kBlockSide - radius ? 1 : 0;
  }
  for (int dz = low[2]; dz <= high[2]; ++dz) {
    for (int dy = low[1]; dy <= high[1]; ++dy) {
      for (int dx = low[0]; dx <= high[0]; ++dx)
        mask |= 1u << (dx + 1 + 3 * (dy + 1) + 9 * (dz + 1));
    }
  }
  return mask;
}

}  // namespace

BlockStore::BlockStore(const MapConfig& config)
    : config_(config), mapped_(config.bounds), reach_(config) {
  mapped_.size += Vec3::Constant(2 * config.resolution_m);
}

Block* BlockStore::obtain(BlockKey b) {
  if (Block* known = find(b)) return known;
  const Plane inside = voxels_inside(b, config_.resolution_m, mapped_);
  const int n = count(inside);
  if (n == 0) return nullptr;
  auto owned = std::make_unique<Block>(b);
  Block* block = owned.get();
  if (n < kBlockVoxels) block->inside = std::make_unique<Plane>(inside);
  meet(*block);
  for (std::size_t i = 0; i < 27; ++i) {
    if (Block* near = block->around[i]) near->around[26 - i] = block;
  }
  blocks_.emplace(pack(b), std::move(owned));
  make_stale(*block);  // its neighbours may block some of it
  return block;
}

void BlockStore::note_changed(Block& block, std::uint32_t border) {
  block.border_changed |= border;
  if (!block.changed) changed_.push_back(&block);
  block.changed = true;
}

bool BlockStore::set_merged(Block& block, int i, Voxel state) {
  const bool free = state == Voxel::kFree, occupied = state == Voxel::kOccupied;
  if (bit(block.merged.free, i) == free && bit(block.merged.occupied, i) == occupied) return false;
  put(block.merged.free, i, free);
  put(block.merged.occupied, i, occupied);
  note_changed(block, near_blocks(i, reach_.radius_voxels()));
  return true;
}

std::uint32_t BlockStore::merge_states(Block& block, std::uint64_t words) {
  std::uint32_t changed = 0;
  for (; words != 0; words &= words - 1) {
    const auto w = static_cast<std::size_t>(std::countr_zero(words));
    std::uint64_t free = 0, occupied = 0;
    for (const auto& [author, states] : block.others) {
      free |= states->free[w];
      occupied |= states->occupied[w];
    }
    free &= ~occupied;
    if (block.own) {
      const std::uint64_t own_free = block.own->states.free[w],
                          own_occupied = block.own->states.occupied[w];
      free = own_free | (free & ~own_occupied);
      occupied = own_occupied | (occupied & ~own_free);
    }
    if (block.inside) {
      free &= (*block.inside)[w];
      occupied &= (*block.inside)[w];
    }
    std::uint64_t diff = (free ^ block.merged.free[w]) | (occupied ^ block.merged.occupied[w]);
    block.merged.free[w] = free;
    block.merged.occupied[w] = occupied;
    changed += static_cast<std::uint32_t>(std::popcount(diff));
    for (; diff != 0; diff &= diff - 1) {
      const int i = static_cast<int>(w) * 64 + std::countr_zero(diff);
      note_changed(block, near_blocks(i, reach_.radius_voxels()));
    }
  }
  return changed;
}

void BlockStore::own_changed(Block& block) {
  if (!block.own_changed) own_changed_.push_back(&block);
  block.own_changed = true;
}

void BlockStore::commit() {
  for (Block* b : changed_) {
    if (b->changed_at != 0) by_change_.erase(b->changed_at);
    b->changed_at = ++revision_;
    by_change_.emplace_hint(by_change_.end(), b->changed_at, b);
    for (std::uint32_t border = b->border_changed; border != 0; border &= border - 1) {
      if (Block* near = b->around[static_cast<std::size_t>(std::countr_zero(border))])
        make_stale(*near);
    }
    b->border_changed = 0;
    b->changed = false;
  }
  for (Block* b : own_changed_) {
    if (b->own_changed_at != 0) by_own_change_.erase(b->own_changed_at);
    b->own_changed_at = ++own_revision_;
    by_own_change_.emplace_hint(by_own_change_.end(), b->own_changed_at, b);
    b->own_changed = false;
  }
  changed_.clear();
  own_changed_.clear();
}

/// Works out the fence and the neighbours of a new block, which do not know it yet; returns how
/// many there are.
std::uint32_t BlockStore::meet(Block& block) const {
  const Plane fence = voxels_inside(block.key, config_.resolution_m, config_.bounds);
  if (count(fence) < kBlockVoxels) block.fence = std::make_unique<Plane>(fence);
  std::uint32_t met = 0;
  for (int i = 0; i < 27; ++i) {
    Block* near =
        i == 13
            ? &block
            : find({block.key.x + i % 3 - 1, block.key.y + i / 3 % 3 - 1, block.key.z + i / 9 - 1});
    block.around[static_cast<std::size_t>(i)] = near;
    met += i != 13 && near;
  }
  return met;
}

void BlockStore::refresh(Block& block) const {
  reach_.refresh(block);
  for (std::size_t w = 0; block.fence && w < 64; ++w) {
    block.traversable[w] &= (*block.fence)[w];
    block.blocked[w] |= ~(*block.fence)[w];
  }
}

void BlockStore::refresh_stale() const {
  for (Block* b : stale_) {
    refresh(*b);
    b->stale = false;
  }
  stale_.clear();
}

Plane BlockStore::blocked_where_unknown(BlockKey b) const {
  Block block(b);
  if (meet(block) > 0 || block.fence || config_.ground) refresh(block);
  return block.blocked;
}

std::vector<BlockKey> BlockStore::since(const Stamps& stamps, std::uint64_t& cursor) {
  std::vector<BlockKey> keys;
  for (auto it = stamps.upper_bound(cursor); it != stamps.end(); ++it)
    keys.push_back(it->second->key);
  if (!stamps.empty()) cursor = stamps.rbegin()->first;
  std::sort(keys.begin(), keys.end());
  return keys;
}

std::vector<const Block*> BlockStore::all() const {
  std::vector<const Block*> result;
  result.reserve(blocks_.size());
  for (const auto& [key, block] : blocks_) result.push_back(block.get());
  std::sort(result.begin(), result.end(),
            [](const Block* a, const Block* b) { return a->key < b->key; });
  return result;
}

}  // namespace muster::map
