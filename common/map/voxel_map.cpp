#include "common/map/voxel_map.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <deque>
#include <fstream>
#include <limits>

#include "common/core/error.h"
#include "common/map/block_store.h"
#include "common/map/own_map.h"
#include "common/map/watch.h"

namespace muster::map {

struct VoxelMap::Impl {
  explicit Impl(const MapConfig& c) : config(c), blocks(c), own(c, blocks) {}
  MapConfig config;
  BlockStore blocks;
  mutable OwnMap own;  // its tree is written late, also when only read
  mutable std::deque<Watch> watches;
};

namespace {

Voxel state(const Block* b, int i) {
  if (!b) return Voxel::kUnknown;
  if (bit(b->merged.occupied, i)) return Voxel::kOccupied;
  return bit(b->merged.free, i) ? Voxel::kFree : Voxel::kUnknown;
}

/// Remembers the last block: neighbours are asked for one after the other.
class Reader {
 public:
  explicit Reader(const BlockStore& blocks) : blocks_(blocks) {}
  Voxel at(VoxelKey k) {
    const BlockKey b = block_of(k);
    if (b != key_) {
      key_ = b;
      block_ = blocks_.find(b);
    }
    return state(block_, local_index(k));
  }

 private:
  const BlockStore& blocks_;
  BlockKey key_{std::numeric_limits<int>::max(), 0, 0};
  const Block* block_ = nullptr;
};

constexpr double kDrivingPlaneM = 0.3;

/// The newer word takes the place of the older one. Returns which words of the planes changed.
std::uint64_t say(States& of, const States& newer) {
  std::uint64_t differ = 0;
  for (std::size_t w = 0; w < 64; ++w) {
    const std::uint64_t free = (of.free[w] & ~newer.occupied[w]) | newer.free[w];
    const std::uint64_t occupied = (of.occupied[w] & ~newer.free[w]) | newer.occupied[w];
    differ |= std::uint64_t{free != of.free[w] || occupied != of.occupied[w]} << w;
    of.free[w] = free;
    of.occupied[w] = occupied;
  }
  return differ;
}

}  // namespace

void take_back(States& older, const States& newer) {
  for (std::size_t w = 0; w < 64; ++w) {
    const std::uint64_t still = ~(newer.free[w] | newer.occupied[w]);
    older.free[w] &= still;
    older.occupied[w] &= still;
  }
}

VoxelMap::VoxelMap(const MapConfig& config) : impl_(std::make_unique<Impl>(config)) {}
VoxelMap::~VoxelMap() = default;

const MapConfig& VoxelMap::config() const { return impl_->config; }

VoxelKey VoxelMap::key(const Vec3& p) const {
  // The hair's breadth makes 0.6 / 0.2 land in voxel 3, as it reads.
  const Vec3 g = (p / impl_->config.resolution_m).array() + 1e-9;
  return {static_cast<int>(std::floor(g.x())), static_cast<int>(std::floor(g.y())),
          static_cast<int>(std::floor(g.z()))};
}

Vec3 VoxelMap::center(VoxelKey k) const {
  return Vec3(k.x + 0.5, k.y + 0.5, k.z + 0.5) * impl_->config.resolution_m;
}

VoxelKey VoxelMap::body_key(const Vec3& p) const {
  VoxelKey k = key(p);
  if (impl_->config.ground && std::abs(p.z() - impl_->config.ride_height_m) < kDrivingPlaneM) {
    k.z = impl_->blocks.reach().driving_layer();
  }
  return k;
}

void VoxelMap::insert_free_ball(const Vec3& center, double radius_m) {
  for (const VoxelKey& k : ball(center, radius_m)) impl_->own.insert_free(k);
  impl_->blocks.commit();
}

void VoxelMap::clear_ball(const Vec3& center, double radius_m) {
  for (const VoxelKey& k : ball(center, radius_m)) impl_->own.clear(k);
  impl_->blocks.commit();
}

void VoxelMap::suppose_free_ball(const Vec3& center, double radius_m) {
  for (const VoxelKey& k : ball(center, radius_m)) {
    if (at(k) == Voxel::kUnknown) impl_->own.insert_free(k);
  }
  impl_->blocks.commit();
}

void VoxelMap::disbelieve_others(const Vec3& center, double radius_m) {
  for (const VoxelKey& k : ball(center, radius_m)) {
    if (at(k) == Voxel::kOccupied) impl_->own.insert_free(k);
  }
  impl_->blocks.commit();
}

/// Voxels whose centres are within `radius_m` of `p`.
std::vector<VoxelKey> VoxelMap::ball(const Vec3& p, double radius_m) const {
  std::vector<VoxelKey> keys;
  const VoxelKey low = key(p - Vec3::Constant(radius_m)), high = key(p + Vec3::Constant(radius_m));
  for (int z = low.z; z <= high.z; ++z) {
    for (int y = low.y; y <= high.y; ++y) {
      for (int x = low.x; x <= high.x; ++x) {
        if ((center({x, y, z}) - p).norm() <= radius_m) keys.push_back({x, y, z});
      }
    }
  }
  return keys;
}

VoxelMap::Integrated VoxelMap::integrate(const RangeScan& scan, std::span<const Sphere> teammates) {
  return impl_->own.integrate(scan, teammates);
}

Voxel VoxelMap::at(VoxelKey k) const {
  return state(impl_->blocks.find(block_of(k)), local_index(k));
}

const octomap::OcTree& VoxelMap::own() const { return impl_->own.tree(); }

BlockView VoxelMap::view(BlockKey b) const {
  impl_->blocks.refresh_reach();
  const Block* block = impl_->blocks.find(b);
  if (!block) return {};
  return {block->merged.free.data(), block->merged.occupied.data(), block->traversable.data(),
          block->blocked.data()};
}

Plane VoxelMap::blocked_where_unknown(BlockKey b) const {
  return impl_->blocks.blocked_where_unknown(b);
}

bool VoxelMap::traversable(VoxelKey k) const {
  impl_->blocks.refresh_reach();
  const Block* b = impl_->blocks.find(block_of(k));
  return b && bit(b->traversable, local_index(k));
}

bool VoxelMap::blocked(VoxelKey k) const {
  impl_->blocks.refresh_reach();
  if (const Block* b = impl_->blocks.find(block_of(k))) {
    return bit(b->blocked, local_index(k));
  }
  const Reach& reach = impl_->blocks.reach();
  if (!impl_->config.bounds.contains(center(k), 1e-9)) return true;
  if (impl_->config.ground && k.z != reach.driving_layer()) return true;
  Reader reader(impl_->blocks);
  return std::ranges::any_of(reach.blocking_offsets(), [&](const VoxelKey& o) {
    return reader.at({k.x + o.x, k.y + o.y, k.z + o.z}) == Voxel::kOccupied;
  });
}

double VoxelMap::clearance(const Vec3& p, double cap_m) const {
  const double edge = impl_->config.resolution_m;
  const Vec3 reach = Vec3::Constant(cap_m);
  const VoxelKey low = key(p - reach), high = key(p + reach);
  const auto gap = [&](double at, int cell) {
    return std::max({0.0, cell * edge - at, at - (cell + 1) * edge});
  };
  double best2 = cap_m * cap_m;
  Reader reader(impl_->blocks);
  for (int z = low.z; z <= high.z; ++z) {
    const double dz = gap(p.z(), z);
    for (int y = low.y; y <= high.y; ++y) {
      const double dy = gap(p.y(), y), dyz2 = dy * dy + dz * dz;
      if (dyz2 >= best2) continue;
      for (int x = low.x; x <= high.x; ++x) {
        const double dx = gap(p.x(), x), d2 = dx * dx + dyz2;
        if (d2 < best2 && reader.at({x, y, z}) == Voxel::kOccupied) best2 = d2;
      }
    }
  }
  return std::sqrt(best2);
}

bool VoxelMap::line_of_sight(const Vec3& a, const Vec3& b, bool through_unknown) const {
  const VoxelKey last = key(b);
  VoxelKey at = key(a);
  if (at == last) return true;
  const Vec3 start = (a / impl_->config.resolution_m).array() + 1e-9,
             way = (b - a) / impl_->config.resolution_m;
  double next[3], delta[3];
  int step[3];
  int* const cell[3] = {&at.x, &at.y, &at.z};
  for (int i = 0; i < 3; ++i) {
    const double base = std::floor(start[i]);
    step[i] = way[i] > 0 ? 1 : -1;
    const bool moves = std::abs(way[i]) > 1e-12;
    delta[i] = moves ? 1 / std::abs(way[i]) : std::numeric_limits<double>::infinity();
    next[i] = moves ? (way[i] > 0 ? base + 1 - start[i] : start[i] - base) * delta[i] : delta[i];
  }
  Reader reader(impl_->blocks);
  for (;;) {
    const int axis = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
    if (next[axis] > 1) return true;
    *cell[axis] += step[axis];
    next[axis] += delta[axis];
    if (at == last) return true;
    const Voxel v = reader.at(at);
    if (v == Voxel::kOccupied || (v == Voxel::kUnknown && !through_unknown)) return false;
  }
}

std::vector<BlockKey> VoxelMap::own_changes(std::uint64_t& cursor) const {
  return impl_->blocks.own_changes(cursor);
}

SaidBlock VoxelMap::own_block(BlockKey b) const {
  const Block* block = impl_->blocks.find(b);
  return {b, block && block->own ? block->own->states : States{}};
}

void VoxelMap::adopt_own(const SaidBlock& own) {
  if (Block* block = impl_->blocks.obtain(own.key)) impl_->own.adopt(*block, own.said);
  impl_->blocks.commit();
}

std::optional<SaidBlock> VoxelMap::news(BlockKey b) const {
  const Block* block = impl_->blocks.find(b);
  if (!block || !block->own) return std::nullopt;
  static const States nothing;
  const States& told = block->told ? *block->told : nothing;
  SaidBlock news{b, block->own->states};
  std::uint64_t any = 0;
  for (std::size_t w = 0; w < 64; ++w) {
    std::uint64_t free = told.free[w], occupied = told.occupied[w];
    for (const auto& [author, states] : block->others) {
      free |= states->free[w];
      occupied |= states->occupied[w];
    }
    // Where somebody else says occupied, a word of free changes nothing: unless it was our own.
    news.said.free[w] &= ~(free | occupied) | told.occupied[w];
    news.said.occupied[w] &= ~occupied | told.free[w];
    any |= news.said.free[w] | news.said.occupied[w];
  }
  return any == 0 ? std::nullopt : std::optional(news);
}

void VoxelMap::told(const SaidBlock& block) {
  Block* const known = impl_->blocks.obtain(block.key);
  if (!known) return;
  if (!known->told) known->told = std::make_unique<States>();
  say(*known->told, block.said);
  impl_->blocks.commit();
}

void VoxelMap::merge(RobotId author, const SaidBlock& block) {
  Block* const known = impl_->blocks.obtain(block.key);
  if (!known) return;
  std::unique_ptr<States>& states = known->others[author];
  if (!states) states = std::make_unique<States>();
  impl_->blocks.merge_states(*known, say(*states, block.said));
  impl_->blocks.commit();
}

std::vector<BlockKey> VoxelMap::changes(std::uint64_t& cursor) const {
  return impl_->blocks.changes(cursor);
}
std::uint64_t VoxelMap::revision() const { return impl_->blocks.revision(); }

std::size_t VoxelMap::watch(const Box& box) const {
  impl_->watches.emplace_back(box, impl_->config);
  return impl_->watches.size() - 1;
}
double VoxelMap::known_m3(std::size_t watched) const {
  return impl_->watches.at(watched).known_m3(impl_->blocks);
}
double VoxelMap::volume_m3(std::size_t watched) const {
  return impl_->watches.at(watched).volume_m3();
}

void VoxelMap::write_bt(const std::string& path) const {
  octomap::OcTree tree(impl_->config.resolution_m);
  std::array<Evidence, kBlockVoxels> evidence;
  for (const Block* b : impl_->blocks.all()) {
    for (int i = 0; i < kBlockVoxels; ++i) {
      const Voxel v = state(b, i);
      evidence[static_cast<std::size_t>(i)] = v == Voxel::kUnknown ? kNoEvidence
                                              : v == Voxel::kFree  ? Evidence{Weights::kFloor}
                                                                   : Evidence{Weights::kCeiling};
    }
    write_block(tree, b->key, evidence);
  }
  // As OctoMap's writeBinary, which also talks on stderr.
  std::ofstream file(path, std::ios::binary);
  tree.toMaxLikelihood();
  tree.prune();
  file
      << "# Octomap OcTree binary file\n# (feel free to add / change comments, but leave the first "
         "line as it is!)\n#\nid "
      << tree.getTreeType() << "\nsize " << tree.size() << "\nres " << tree.getResolution()
      << "\ndata\n";
  tree.writeBinaryData(file);
  if (!file.flush()) throw Failure(path + ": cannot be written");
}

}  // namespace muster::map
