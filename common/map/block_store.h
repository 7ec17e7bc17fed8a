#pragma once

#include <map>
#include <unordered_map>
#include <vector>

#include "common/map/block.h"
#include "common/map/reach.h"

namespace muster::map {

/// All blocks of one map, who is next to whom, and in which order they changed.
///
/// Whoever changes voxels calls `merged_changed` / `own_changed` for each and `commit` once at the
/// end; readers then see a new revision.
class BlockStore {
 public:
  explicit BlockStore(const MapConfig& config);

  Block* find(BlockKey b) const {
    const auto it = blocks_.find(pack(b));
    return it == blocks_.end() ? nullptr : it->second.get();
  }
  /// Null when the whole block is out of bounds.
  Block* obtain(BlockKey b);

  /// Sets one voxel of the merged map; true when that changed it.
  bool set_merged(Block& block, int i, Voxel state);
  /// Recomputes the merged states of a block from own and others'; returns how many changed. Only
  /// the `words` of its planes whose bits are set.
  std::uint32_t merge_states(Block& block, std::uint64_t words = ~std::uint64_t{0});
  void own_changed(Block& block);
  /// Ends an operation: stamps what changed.
  void commit();

  /// Brings `traversable` and `blocked` of all blocks up to date. Cheap when nothing changed.
  void refresh_reach() const {
    if (!stale_.empty()) refresh_stale();
  }

  /// `blocked` of a block that is not there.
  Plane blocked_where_unknown(BlockKey b) const;

  std::vector<BlockKey> changes(std::uint64_t& cursor) const { return since(by_change_, cursor); }
  std::vector<BlockKey> own_changes(std::uint64_t& cursor) const {
    return since(by_own_change_, cursor);
  }
  std::uint64_t revision() const { return revision_; }
  const Reach& reach() const { return reach_; }
  /// Every block, in order of key.
  std::vector<const Block*> all() const;

 private:
  using Stamps = std::map<std::uint64_t, Block*>;
  static std::vector<BlockKey> since(const Stamps& stamps, std::uint64_t& cursor);
  void note_changed(Block& block, std::uint32_t border);
  void refresh_stale() const;
  void refresh(Block& block) const;
  std::uint32_t meet(Block& block) const;
  void make_stale(Block& block) {
    if (!block.stale) stale_.push_back(&block);
    block.stale = true;
  }

  MapConfig config_;
  Box mapped_;  ///< the bounds and one voxel around: the ground at the bottom of the hull must be
                ///< seen
  Reach reach_;
  std::unordered_map<std::uint64_t, std::unique_ptr<Block>>
      blocks_;  // looked up, never walked where order matters
  Stamps by_change_, by_own_change_;
  std::vector<Block*> changed_, own_changed_;
  mutable std::vector<Block*> stale_;
  std::uint64_t revision_ = 0, own_revision_ = 0;
};

}  // namespace muster::map
