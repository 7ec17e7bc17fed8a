#include "common/map/region_cells.h"

#include <cmath>

namespace muster::map {
namespace {

constexpr double kLowestSurfaceM =
    0.8;  // features are above 1 m; a voxel and the sighting's error below that
constexpr std::uint8_t kVainLooks = 3;
const Plane kNothing{};

std::vector<BlockKey> blocks_of(const Box& box, double block_m) {
  const auto index = [&](double v) { return static_cast<int>(std::floor(v / block_m)); };
  const Vec3 low = box.low(), high = box.high();
  std::vector<BlockKey> keys;
  for (int x = index(low.x()); x <= index(high.x()); ++x) {
    for (int y = index(low.y()); y <= index(high.y()); ++y) {
      for (int z = index(low.z()); z <= index(high.z()); ++z) keys.push_back({x, y, z});
    }
  }
  return keys;
}

CellClusters::Neighbours neighbours_of(const std::vector<BlockKey>& keys) {
  std::map<BlockKey, int> index;
  for (const BlockKey& k : keys) index.emplace(k, static_cast<int>(index.size()));
  CellClusters::Neighbours result(keys.size());
  for (std::size_t s = 0; s < keys.size(); ++s) {
    for (int i = 0; i < 27; ++i) {
      const auto it =
          index.find({keys[s].x + i % 3 - 1, keys[s].y + i / 3 % 3 - 1, keys[s].z + i / 9 - 1});
      result[s][static_cast<std::size_t>(i)] = it == index.end() ? -1 : it->second;
    }
  }
  return result;
}

/// Index among the 27 blocks around of the one beyond `face`.
std::size_t beyond(int face) {
  const VoxelKey& d = kFaces[face];
  const int index = d.x + 1 + 3 * (d.y + 1) + 9 * (d.z + 1);
  return static_cast<std::size_t>(index);
}

Plane plane(const std::uint64_t* words) {
  Plane p{};
  if (words) std::copy(words, words + p.size(), p.begin());
  return p;
}

}  // namespace

RegionCells::RegionCells(const VoxelMap& map, const Box& box, std::uint32_t looks,
                         double max_extent_m)
    : map_(map),
      looks_(looks),
      neighbours_(neighbours_of(blocks_of(box, map.config().resolution_m * kBlockSide))),
      frontier_(blocks_of(box, map.config().resolution_m * kBlockSide), neighbours_,
                map.config().resolution_m, max_extent_m),
      owed_(blocks_of(box, map.config().resolution_m * kBlockSide), neighbours_,
            map.config().resolution_m, max_extent_m) {
  const double edge = map.config().resolution_m;
  for (const BlockKey& k : blocks_of(box, edge * kBlockSide)) {
    Slot slot;
    slot.key = k;
    slot.inside = voxels_inside(k, edge, box);
    const Plane mapped = voxels_inside(k, edge, map.config().bounds);
    for (std::size_t w = 0; w < 64; ++w) {
      slot.inside[w] &= mapped[w];
      const int z = k.z * kBlockSide + static_cast<int>(w / 4);
      if ((z + 0.5) * edge >= kLowestSurfaceM) slot.high_enough[w] = slot.inside[w];
    }
    slot.unknown = slot.inside;
    slots_.push_back(std::move(slot));
  }
  first_ = slots_.front().key;
  const BlockKey last = slots_.back().key;
  nx_ = last.x - first_.x + 1;
  ny_ = last.y - first_.y + 1;
  nz_ = last.z - first_.z + 1;
}

void RegionCells::mark_around(std::size_t slot) {
  slots_[slot].dirty = true;
  for (int face = 0; face < 6; ++face) {
    const int n = neighbours_[slot][beyond(face)];
    if (n >= 0) slots_[static_cast<std::size_t>(n)].dirty = true;
  }
}

void RegionCells::update() {
  for (const BlockKey& b : map_.changes(cursor_)) {
    // A changed block just outside the box may lay bare a surface inside.
    for (int face = 0; face < 6; ++face) {
      if (Slot* beside =
              slot_of({b.x + kFaces[face].x, b.y + kFaces[face].y, b.z + kFaces[face].z}))
        beside->dirty = true;
    }
    Slot* slot = slot_of(b);
    if (!slot) continue;
    slot->dirty = true;
    const BlockView view = map_.view(b);
    for (std::size_t w = 0; w < 64; ++w)
      slot->unknown[w] = slot->inside[w] & ~(view.free[w] | view.occupied[w]);
    const int known = count(slot->inside) - count(slot->unknown);
    if (known > slot->known) growth_ += static_cast<std::uint64_t>(known - slot->known);
    slot->known = std::max(slot->known, known);
  }
  settle();
}

void RegionCells::settle() {
  for (std::size_t s = 0; s < slots_.size(); ++s) {
    if (slots_[s].dirty) recompute(s);
  }
}

void RegionCells::recompute(std::size_t index) {
  Slot& slot = slots_[index];
  slot.dirty = false;
  const BlockView view = map_.view(slot.key);
  if (!view) return;
  const Plane free = plane(view.free);
  Plane beside_unknown{}, beside_free{}, credit{}, lateral{}, face_owed{}, level_owed{};
  for (int face = 0; face < 6; ++face) {
    const VoxelKey& d = kFaces[face];
    const auto f = static_cast<std::size_t>(face);
    const auto neighbour = [&](int to) -> const Slot* {
      const int n = neighbours_[index][beyond(to)];
      return n < 0 ? nullptr : &slots_[static_cast<std::size_t>(n)];
    };
    const Slot *ahead = neighbour(face), *behind = neighbour(face ^ 1);
    const Plane free_ahead = shifted(
        free, plane(map_.view({slot.key.x + d.x, slot.key.y + d.y, slot.key.z + d.z}).free), face);
    const Plane unknown_ahead = shifted(slot.unknown, ahead ? ahead->unknown : kNothing, face);
    const Plane seen_ahead = shifted(slot.seen, ahead ? ahead->seen : kNothing, face);
    const Plane seen_behind = shifted(slot.seen, behind ? behind->seen : kNothing, face ^ 1);
    for (std::size_t w = 0; w < 64; ++w) {
      beside_unknown[w] |= unknown_ahead[w];
      beside_free[w] |= free_ahead[w];
      // Noise moves a surface by a voxel along its normal: the looks at it still count.
      credit[w] |= free_ahead[w] & (seen_ahead[w] | seen_behind[w]);
    }
    const Plane face_ahead =
        shifted(slot.face_seen[f], ahead ? ahead->face_seen[f] : kNothing, face);
    const Plane face_behind =
        shifted(slot.face_seen[f], behind ? behind->face_seen[f] : kNothing, face ^ 1);
    Plane& owed_here = d.z == 0 ? face_owed : level_owed;
    for (std::size_t w = 0; w < 64; ++w) {
      if (d.z == 0) lateral[w] |= free_ahead[w];
      owed_here[w] |= free_ahead[w] & ~(slot.face_seen[f][w] | face_ahead[w] | face_behind[w]);
    }
  }
  Plane frontier, owed;
  for (std::size_t w = 0; w < 64; ++w) {
    frontier[w] = free[w] & slot.inside[w] & beside_unknown[w] & ~slot.given_up[w];
    const std::uint64_t rarely = ~slot.seen[w] & ~credit[w];
    const std::uint64_t sides = sides_ ? face_owed[w] | (level_owed[w] & lateral[w]) : 0;
    owed[w] = view.occupied[w] & slot.high_enough[w] & beside_free[w] & (rarely | sides);
  }
  if (looks_ > 0) {
    Plane fresh;
    for (std::size_t w = 0; w < 64; ++w) {
      fresh[w] = owed[w] & ~slot.told[w];
      slot.told[w] |= owed[w];
    }
    for_each_bit(fresh, [&](int i) { new_surface_.push_back(voxel_in(slot.key, i)); });
  }
  frontier_.set(index, frontier);
  owed_.set(index, looks_ == 0 ? kNothing : owed);
}

void RegionCells::ask_for_sides(bool ask) {
  if (std::exchange(sides_, ask) == ask) return;
  for (Slot& slot : slots_) slot.dirty = true;
}

void RegionCells::looked_in_vain(VoxelKey k) {
  Slot* slot = slot_of(block_of(k));
  if (!slot || ++slot->vain[local_index(k)] < kVainLooks) return;
  slot->vain.erase(local_index(k));
  put(slot->given_up, local_index(k), true);
  slot->dirty = true;
}

FaceSet RegionCells::owed_faces(VoxelKey k) const {
  const std::size_t i = index_of(block_of(k));
  const int at = local_index(k);
  if (i == kNone || !bit(owed_.marks(i), at)) return 0;
  const Slot& slot = slots_[i];
  const bool rarely = slot.looks.empty() || slot.looks[static_cast<std::size_t>(at)] < looks_;
  FaceSet open = 0, lateral = 0, unseen = 0;
  for (int face = 0; face < 6; ++face) {
    const VoxelKey& d = kFaces[face];
    if (map_.at(VoxelKey{k.x + d.x, k.y + d.y, k.z + d.z}) != Voxel::kFree) continue;
    const auto one = static_cast<FaceSet>(1u << face);
    open |= one;
    if (d.z == 0) lateral |= one;
    if (!bit(slot.face_seen[static_cast<std::size_t>(face)], at)) unseen |= one;
  }
  if (rarely) return open;
  return sides_ && lateral != 0 ? unseen : 0;
}

bool RegionCells::owed_from(VoxelKey k, const Vec3& eye) const {
  const FaceSet owed = owed_faces(k);
  if (owed == 0) return false;
  const Vec3 towards = (eye - map_.center(k)).normalized();
  for (int face = 0; face < 6; ++face) {
    if ((owed >> face & 1) != 0 && towards.dot(face_normal(face)) > kLeastFacing) return true;
  }
  return false;
}

void RegionCells::count_look(VoxelKey k, FaceSet faces) {
  const std::size_t index = index_of(block_of(k));
  if (index == kNone) return;
  Slot& slot = slots_[index];
  const int at = local_index(k);
  if (slot.looks.empty()) slot.looks.assign(kBlockVoxels, 0);
  bool news = false;
  for (int face = 0; face < 6; ++face) {
    Plane& seen = slot.face_seen[static_cast<std::size_t>(face)];
    if ((faces >> face & 1) == 0 || bit(seen, at)) continue;
    put(seen, at, true);
    news = true;
  }
  std::uint8_t& n = slot.looks[static_cast<std::size_t>(at)];
  if (n < looks_ || news) ++looks_counted_;
  if (n < 255 && ++n == looks_) {
    put(slot.seen, at, true);
    news = true;
  }
  if (news) mark_around(index);
}

}  // namespace muster::map
