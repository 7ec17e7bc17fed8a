#include "common/map/region_cells.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "common/map/voxel_reader.h"

namespace muster::map {
namespace {

constexpr double kLowestSurfaceM =
    0.8;  // features are above 1 m; a voxel and the sighting's error below that
constexpr std::uint8_t kVainLooks = 3;
// Percent that a look at a surface voxel promises, by the looks that it had: none, one, enough but
// not from this side. README "What a look promises" has the measurements.
constexpr std::uint8_t kEdge[] = {100, 40, 30};  // faces to the side and up or down
constexpr std::uint8_t kSide[] = {100, 50, 20};  // to the side only
constexpr std::uint8_t kStep[] = {10, 0, 0};     // to the side only, and no wall
constexpr std::uint8_t kLevel[] = {20, 0, 8};    // up or down only: floors, ceilings, roofs
// Sides below an overhang, by the sectors that looks came from: a slit narrower than a voxel shows
// its depth only to looks along it.
constexpr std::uint8_t kNook[] = {30, 30, 15};
constexpr double kLevelWithEdge = 0.1;  // height over distance: below it the corner shows
constexpr int kWall = 2;                // of the eight around it, at least
const Plane kNothing{};
constexpr int kUp = 4;  // of kFaces

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

Sectors sector_of(const Vec3& d) {
  const double eighths = (std::atan2(d.y(), d.x()) + std::numbers::pi) / (std::numbers::pi / 4);
  return static_cast<Sectors>(1u << std::min(7, static_cast<int>(eighths)));
}

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

/// The surface voxels of a block by what of them was looked at.
struct RegionCells::Surfaces {
  Plane never{}, rarely{};          ///< looked at: not once, not often enough
  Plane side_open{}, level_open{};  ///< faces to the side, up or down that are open
  Plane side_owed{}, level_owed{};  ///< and that nobody looked at
  Plane nook{};                     ///< sides below an overhang
};

void RegionCells::recompute(std::size_t index) {
  Slot& slot = slots_[index];
  slot.dirty = false;
  const BlockView view = map_.view(slot.key);
  if (!view) return;
  const Plane free = plane(view.free), under_here = under_overhang(slot.key);
  Plane beside_unknown{}, once{}, often{};
  Surfaces s;
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
    // Noise moves a surface by a voxel along its normal: the looks at it still count. (Those at the
    // same face only: behind the underside of a roof lies its upper side.)
    const auto along = [&](const Plane& own, const Plane& next, const Plane& last) {
      Plane both = shifted(own, next, face);
      const Plane other = shifted(own, last, face ^ 1);
      for (std::size_t w = 0; w < 64; ++w) both[w] |= other[w];
      return both;
    };
    const Plane seen_along =
        along(slot.seen, ahead ? ahead->seen : kNothing, behind ? behind->seen : kNothing);
    const Plane face_along = along(slot.face_seen[f], ahead ? ahead->face_seen[f] : kNothing,
                                   behind ? behind->face_seen[f] : kNothing);
    if (d.z == 0) {
      const Plane below = shifted(
          under_here, under_overhang({slot.key.x + d.x, slot.key.y + d.y, slot.key.z}), face);
      for (std::size_t w = 0; w < 64; ++w) s.nook[w] |= below[w];
    }
    Plane& open_here = d.z == 0 ? s.side_open : s.level_open;
    Plane& owed_here = d.z == 0 ? s.side_owed : s.level_owed;
    for (std::size_t w = 0; w < 64; ++w) {
      beside_unknown[w] |= unknown_ahead[w];
      once[w] |= free_ahead[w] & face_along[w];
      often[w] |= free_ahead[w] & face_along[w] & seen_along[w];
      open_here[w] |= free_ahead[w];
      owed_here[w] |= free_ahead[w] & ~(slot.face_seen[f][w] | face_along[w]);
    }
  }
  Plane frontier, owed;
  for (std::size_t w = 0; w < 64; ++w) {
    frontier[w] = free[w] & slot.inside[w] & beside_unknown[w] & ~slot.given_up[w];
    s.never[w] = ~slot.once[w] & ~once[w];
    s.rarely[w] = ~slot.seen[w] & ~often[w];
    const std::uint64_t sides = s.side_owed[w] | (s.level_owed[w] & s.side_open[w]);
    const std::uint64_t surface =
        view.occupied[w] & slot.high_enough[w] & (s.side_open[w] | s.level_open[w]);
    owed[w] = surface & (s.rarely[w] | sides);
    s.nook[w] &= surface;
  }
  if (looks_ == 0) owed = s.nook = kNothing;
  weigh(slot, s, owed);
  weigh_nooks(slot, s, owed);
  if (looks_ > 0) {
    Plane fresh;
    for (std::size_t w = 0; w < 64; ++w) {
      fresh[w] = owed[w] & ~slot.told[w];
      slot.told[w] |= owed[w];
    }
    surfaces_ += static_cast<std::uint64_t>(count(fresh));
    for_each_bit(fresh, [&](int i) { new_surface_.push_back(voxel_in(slot.key, i)); });
  }
  frontier_.set(index, frontier);
  owed_.set(index, owed);
}

/// Of the eight around a voxel, in the plane of a face, how many have the same face open: a
/// surface, or a step of noise. The best of `faces`.
int RegionCells::support(VoxelKey k, FaceSet faces) const {
  VoxelReader reader(map_);
  int best = 0;
  for (int face = 0; face < 6; ++face) {
    if ((faces >> face & 1) == 0) continue;
    const VoxelKey& d = kFaces[face];
    int n = 0;
    for (int i = 0; i < 9; ++i) {
      const int a = i % 3 - 1, b = i / 3 - 1;
      if (a == 0 && b == 0) continue;
      const VoxelKey q = d.x != 0   ? VoxelKey{k.x, k.y + a, k.z + b}
                         : d.y != 0 ? VoxelKey{k.x + a, k.y, k.z + b}
                                    : VoxelKey{k.x + a, k.y + b, k.z};
      n += reader.at(q) == Voxel::kOccupied && reader.free({q.x + d.x, q.y + d.y, q.z + d.z});
    }
    best = std::max(best, n);
  }
  return best;
}

/// Free voxels with an occupied one above.
Plane RegionCells::under_overhang(BlockKey b) const {
  const BlockView view = map_.view(b);
  if (!view) return kNothing;
  Plane under = shifted(plane(view.occupied), plane(map_.view({b.x, b.y, b.z + 1}).occupied), kUp);
  for (std::size_t w = 0; w < 64; ++w) under[w] &= view.free[w];
  return under;
}

Sectors RegionCells::sectors_at(VoxelKey k) const {
  const std::size_t i = index_of(block_of(k));
  if (i == kNone || slots_[i].sectors.empty()) return 0;
  return slots_[i].sectors[static_cast<std::size_t>(local_index(k))];
}

/// The looks at what is now here, though noise may have moved it by a voxel since.
Sectors RegionCells::sectors_around(VoxelKey k) const {
  Sectors seen = sectors_at(k);
  for (int face = 0; face < 4; ++face)
    seen |= sectors_at({k.x + kFaces[face].x, k.y + kFaces[face].y, k.z});
  return seen;
}

/// Fills in the promise of owed voxels, and unmarks what promises next to nothing.
void RegionCells::weigh(Slot& slot, const Surfaces& s, Plane& owed) const {
  if (slot.promise.empty() && (owed != kNothing || s.nook != kNothing))
    slot.promise.assign(kBlockVoxels, 0);
  for_each_bit(owed, [&](int i) {
    const std::size_t looks = bit(s.never, i) ? 0 : bit(s.rarely, i) ? 1 : 2;
    const bool side = bit(looks < 2 ? s.side_open : s.side_owed, i);
    const bool level = bit(looks < 2 ? s.level_open : s.level_owed, i);
    std::uint8_t promise = kEdge[looks];
    if (side && !level) {
      const VoxelKey k = voxel_in(slot.key, i);
      const Faces f = faces_of(slot, k);
      const auto faces = static_cast<FaceSet>(looks == 2 ? f.lateral & f.unseen : f.lateral);
      promise = support(k, faces) < kWall ? kStep[looks] : kSide[looks];
    } else if (!side) {
      promise = kLevel[looks];
    }
    slot.promise[static_cast<std::size_t>(i)] = promise;
    if (promise == 0) put(owed, i, false);
  });
}

/// Marks what is owed nothing else, but lies below an overhang and was seen from few sides.
void RegionCells::weigh_nooks(Slot& slot, const Surfaces& s, Plane& owed) const {
  slot.nook = kNothing;
  for_each_bit(s.nook, [&](int i) {
    if (bit(owed, i)) return;
    const auto n = static_cast<std::size_t>(std::popcount(sectors_around(voxel_in(slot.key, i))));
    if (n >= std::size(kNook)) return;
    slot.promise[static_cast<std::size_t>(i)] = kNook[n];
    put(slot.nook, i, true);
    put(owed, i, true);
  });
}

Sectors RegionCells::exhausted_sectors(VoxelKey k) const {
  const std::size_t i = index_of(block_of(k));
  return i != kNone && bit(slots_[i].nook, local_index(k)) ? sectors_around(k) : Sectors{0};
}

double RegionCells::promise(VoxelKey k) const {
  const std::size_t i = index_of(block_of(k));
  const int at = local_index(k);
  if (i == kNone || !bit(owed_.marks(i), at)) return 0;
  if (!nooks_asked_ && bit(slots_[i].nook, at)) return 0;
  return slots_[i].promise[static_cast<std::size_t>(at)] / 100.0;
}

void RegionCells::looked_in_vain(VoxelKey k) {
  Slot* slot = slot_of(block_of(k));
  if (!slot || ++slot->vain[local_index(k)] < kVainLooks) return;
  slot->vain.erase(local_index(k));
  put(slot->given_up, local_index(k), true);
  slot->dirty = true;
}

RegionCells::Faces RegionCells::faces_of(const Slot& slot, VoxelKey k) const {
  Faces faces;
  for (int face = 0; face < 6; ++face) {
    const VoxelKey& d = kFaces[face];
    if (map_.at(VoxelKey{k.x + d.x, k.y + d.y, k.z + d.z}) != Voxel::kFree) continue;
    const auto one = static_cast<FaceSet>(1u << face);
    faces.open |= one;
    if (d.z == 0) faces.lateral |= one;
    if (!bit(slot.face_seen[static_cast<std::size_t>(face)], local_index(k))) faces.unseen |= one;
  }
  return faces;
}

FaceSet RegionCells::owed_faces(VoxelKey k) const {
  const std::size_t i = index_of(block_of(k));
  const int at = local_index(k);
  if (i == kNone || !bit(owed_.marks(i), at)) return 0;
  const Slot& slot = slots_[i];
  const bool rarely = slot.looks.empty() || slot.looks[static_cast<std::size_t>(at)] < looks_;
  const Faces f = faces_of(slot, k);
  if (bit(slot.nook, at)) return f.lateral;
  if (rarely) return f.open;
  return f.lateral != 0 ? f.unseen : 0;
}

double RegionCells::promise_from(VoxelKey k, const Vec3& eye) const {
  const FaceSet owed = owed_faces(k);
  if (owed == 0) return 0;
  const Vec3 towards = (eye - map_.center(k)).normalized();
  if ((exhausted_sectors(k) & sector_of(towards)) != 0) return 0;
  for (int face = 0; face < 6; ++face) {
    if ((owed >> face & 1) == 0 || towards.dot(face_normal(face)) <= kLeastFacing) continue;
    if (towards.z() <= kLevelWithEdge || !overhung(k, face)) return promise(k);
  }
  return 0;
}

bool RegionCells::overhung(VoxelKey k, int face) const {
  const VoxelKey& d = kFaces[face];
  return d.z == 0 && map_.at(VoxelKey{k.x + d.x, k.y + d.y, k.z + 1}) == Voxel::kOccupied;
}

void RegionCells::count_look(VoxelKey k, FaceSet faces, const Vec3& eye) {
  const std::size_t index = index_of(block_of(k));
  if (index == kNone) return;
  Slot& slot = slots_[index];
  const int at = local_index(k);
  if (slot.looks.empty()) {
    slot.looks.assign(kBlockVoxels, 0);
    slot.sectors.assign(kBlockVoxels, 0);
  }
  bool news = false;
  Sectors& sectors = slot.sectors[static_cast<std::size_t>(at)];
  const Sectors from = sector_of(eye - map_.center(k));
  if (bit(slot.nook, at) && (sectors & from) == 0) news = true;
  sectors |= from;
  for (int face = 0; face < 6; ++face) {
    Plane& seen = slot.face_seen[static_cast<std::size_t>(face)];
    if ((faces >> face & 1) == 0 || bit(seen, at)) continue;
    put(seen, at, true);
    news = true;
  }
  std::uint8_t& n = slot.looks[static_cast<std::size_t>(at)];
  if (n < looks_ || news) ++looks_counted_;
  if (n == 0) put(slot.once, at, true), news = true;
  if (n < 255 && ++n == looks_) put(slot.seen, at, true), news = true;
  if (news) mark_around(index);
}

}  // namespace muster::map
