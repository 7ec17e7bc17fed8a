#include "common/map/region_cells.h"

#include <algorithm>
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
                         double max_extent_m, const LeastTilt& least_tilt)
    : map_(map),
      looks_(std::min(looks, kMostLooks)),
      least_tilt_(least_tilt),
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
  Plane frontier{};
  std::array<Plane, 6> free_ahead;
  for (int face = 0; face < 6; ++face) {
    const VoxelKey& d = kFaces[face];
    const int n = neighbours_[index][beyond(face)];
    free_ahead[static_cast<std::size_t>(face)] = shifted(
        free, plane(map_.view({slot.key.x + d.x, slot.key.y + d.y, slot.key.z + d.z}).free), face);
    const Plane unknown_ahead =
        shifted(slot.unknown, n < 0 ? kNothing : slots_[static_cast<std::size_t>(n)].unknown, face);
    for (std::size_t w = 0; w < 64; ++w)
      frontier[w] |= free[w] & slot.inside[w] & unknown_ahead[w] & ~slot.given_up[w];
  }
  frontier_.set(index, frontier);
  if (looks_ > 0) owed_.set(index, recompute_surface(index, free_ahead));
}

/// Which faces of the block's surface are open and owed looks; returns the voxels that have any.
Plane RegionCells::recompute_surface(std::size_t index, const std::array<Plane, 6>& free_ahead) {
  Slot& slot = slots_[index];
  const BlockView view = map_.view(slot.key);
  Plane surface, any{};
  bool some = slot.looks != nullptr;
  for (std::size_t w = 0; w < 64; ++w) {
    surface[w] = view.occupied[w] & slot.high_enough[w];
    some = some || surface[w] != 0;
  }
  if (!some) return any;
  if (!slot.looks) slot.looks = std::make_unique<FaceLooks>();
  FaceLooks& looks = *slot.looks;
  Plane fresh{};
  std::array<Plane, 6> fresh_face;
  for (std::size_t f = 0; f < 6; ++f) {
    for (std::size_t w = 0; w < 64; ++w) looks.open[f][w] = surface[w] & free_ahead[f][w];
  }
  for (int face = 0; face < 6; ++face) {
    const auto f = static_cast<std::size_t>(face);
    // Noise moves a surface by a voxel along its normal: the looks at it still count.
    const auto seen_beyond = [&](int way) {
      const int n = neighbours_[index][beyond(way)];
      const FaceLooks* other = n < 0 ? nullptr : slots_[static_cast<std::size_t>(n)].looks.get();
      return shifted(looks.seen[f], other ? other->seen[f] : kNothing, way);
    };
    const Plane seen_ahead = seen_beyond(face), seen_behind = seen_beyond(face ^ 1);
    for (std::size_t w = 0; w < 64; ++w) {
      looks.owed[f][w] = looks.open[f][w] & ~(looks.seen[f][w] | seen_ahead[w] | seen_behind[w]);
      any[w] |= looks.owed[f][w];
    }
  }
  leave_level(slot, 4, least_tilt_.up_rad, any);
  leave_level(slot, 5, least_tilt_.down_rad, any);
  any = {};
  for (std::size_t f = 0; f < 6; ++f) {
    for (std::size_t w = 0; w < 64; ++w) {
      any[w] |= looks.owed[f][w];
      fresh_face[f][w] = looks.owed[f][w] & ~looks.told[f][w];
      fresh[w] |= fresh_face[f][w];
      looks.told[f][w] |= looks.owed[f][w];
    }
  }
  for_each_bit(fresh, [&](int i) {
    FaceSet set = 0;
    for (std::size_t f = 0; f < 6; ++f) {
      if (bit(fresh_face[f], i)) set = static_cast<FaceSet>(set | 1u << f);
    }
    new_surface_.push_back({voxel_in(slot.key, i), set});
  });
  return any;
}

double RegionCells::hidden(VoxelKey k) const {
  const FaceSet owed = owed_faces(k);
  double side = 0, other_side = 0;
  for (int f = 0; f < 6; f += 2) {
    const double ahead = (owed >> f & 1) != 0 ? kMissed[looks(k, f)] : 0;
    const double behind = (owed >> (f + 1) & 1) != 0 ? kMissed[looks(k, f + 1)] : 0;
    side = std::max({side, ahead, behind});
    other_side = std::max(other_side, std::min(ahead, behind));
  }
  return side + other_side;
}

/// Level surfaces that face up or down (`face`) are not owed looks, nor are the steps of one voxel
/// that noise makes in them.
void RegionCells::leave_level(Slot& slot, int face, double least_tilt_rad, const Plane& owed) {
  if (least_tilt_rad <= 0) return;
  FaceLooks& looks = *slot.looks;
  Plane candidates;
  for (std::size_t w = 0; w < 64; ++w)
    candidates[w] = owed[w] & looks.open[static_cast<std::size_t>(face)][w];
  for_each_bit(candidates, [&](int i) {
    const VoxelKey k = voxel_in(slot.key, i);
    if (!level(k, face, least_tilt_rad)) return;
    put(looks.owed[static_cast<std::size_t>(face)], i, false);
    for (int side = 0; side < 4; ++side) {
      const VoxelKey& d = kFaces[side];
      const VoxelKey step{k.x + d.x, k.y + d.y, k.z - kFaces[face].z};
      if (open_row(step, face, 0) != 0) put(looks.owed[static_cast<std::size_t>(side)], i, false);
    }
  });
}

/// Open faces of the voxels from −half to +half along x around `k`, as bits from 0.
std::uint32_t RegionCells::open_row(VoxelKey k, int face, int half) const {
  const auto bits = [&](int block_x) -> std::uint32_t {
    const std::size_t i = index_of({block_x, k.y >> 4, k.z >> 4});
    if (i == kNone || !slots_[i].looks) return 0;
    return row(slots_[i].looks->open[static_cast<std::size_t>(face)].data(), k.y & 15, k.z & 15);
  };
  const int first = k.x - half, block_x = first >> 4;
  std::uint32_t wide = bits(block_x);
  if ((k.x + half) >> 4 != block_x) wide |= bits(block_x + 1) << 16;
  return wide >> (first & 15) & ((1u << (2 * half + 1)) - 1);
}

/// Is the surface that this face is a part of more level than that? A plane is fitted to the same
/// faces of the columns around, one voxel higher or lower at most.
bool RegionCells::level(VoxelKey k, int face, double least_tilt_rad) const {
  constexpr int kHalf = 4, kLeast = 15;
  constexpr double kLeastSpread = 0.6, kRough = 0.6;  // voxels: standard deviations
  double n = 0, sx = 0, sy = 0, sh = 0, sxx = 0, syy = 0, sxy = 0, sxh = 0, syh = 0, shh = 0;
  for (int y = -kHalf; y <= kHalf; ++y) {
    std::uint32_t had = 0;
    for (const int h : {0, 1, -1}) {
      const std::uint32_t bits = open_row({k.x, k.y + y, k.z + h}, face, kHalf) & ~had;
      had |= bits;
      for (std::uint32_t left = bits; left != 0; left &= left - 1) {
        const int x = __builtin_ctz(left) - kHalf;
        n += 1, sx += x, sy += y, sh += h;
        sxx += x * x, syy += y * y, sxy += x * y;
        sxh += x * h, syh += y * h, shh += h * h;
      }
    }
  }
  if (n < kLeast) return false;
  sxx -= sx * sx / n, syy -= sy * sy / n, sxy -= sx * sy / n;
  sxh -= sx * sh / n, syh -= sy * sh / n, shh -= sh * sh / n;
  const double det = sxx * syy - sxy * sxy;
  if (std::min(sxx, syy) < n * kLeastSpread * kLeastSpread || det < 1e-6 * sxx * syy) return false;
  const double a = (sxh * syy - syh * sxy) / det, b = (syh * sxx - sxh * sxy) / det;
  const double residual = shh - a * sxh - b * syh;
  return std::hypot(a, b) < std::tan(least_tilt_rad) && residual < n * kRough * kRough;
}

void RegionCells::looked_in_vain(VoxelKey k) {
  Slot* slot = slot_of(block_of(k));
  if (!slot || ++slot->vain[local_index(k)] < kVainLooks) return;
  slot->vain.erase(local_index(k));
  put(slot->given_up, local_index(k), true);
  slot->dirty = true;
}

void RegionCells::count_look(VoxelKey k, FaceSet faces) {
  const std::size_t index = index_of(block_of(k));
  if (index == kNone || !slots_[index].looks) return;
  FaceLooks& looks = *slots_[index].looks;
  const int at = local_index(k);
  bool enough = false, counted = false;
  const double before = hidden(k);
  for (int f = 0; f < 6; ++f) {
    const std::uint32_t n = looks.count(at, f);
    if ((faces >> f & 1) == 0 || n >= looks_) continue;
    looks.counts[static_cast<std::size_t>(at)] =
        static_cast<std::uint16_t>(looks.counts[static_cast<std::size_t>(at)] + (1u << (2 * f)));
    counted = true;
    if (n + 1 < looks_) continue;
    put(looks.seen[static_cast<std::size_t>(f)], at, true);
    enough = true;
  }
  looks_counted_ += counted ? 1 : 0;
  shown_ += before - hidden(k);
  if (enough) mark_around(index);
}

}  // namespace muster::map
