#include "commsim/world/coverage.h"

#include <algorithm>
#include <cmath>

#include "common/dds/convert.h"
#include "common/dds/map_block.h"
#include "common/map/block.h"

namespace muster::world {
namespace {

Vec3 center(map::VoxelKey k, double resolution_m) {
  return Vec3(k.x + 0.5, k.y + 0.5, k.z + 0.5) * resolution_m;
}

}  // namespace

std::uint64_t voxel_number(map::VoxelKey k) {
  const auto part = [](int v) { return static_cast<std::uint64_t>(v + (1 << 20)) & 0x1FFFFF; };
  return part(k.x) << 42 | part(k.y) << 21 | part(k.z);
}

map::VoxelKey voxel_at(const Vec3& p, double resolution_m) {
  return {static_cast<int>(std::floor(p.x() / resolution_m)),
          static_cast<int>(std::floor(p.y() / resolution_m)),
          static_cast<int>(std::floor(p.z() / resolution_m))};
}

Coverage::Coverage(const mission::Mission& mission, const std::vector<Vec3>& surface)
    : resolution_m_(mission.resolution_m), boxes_(mission.boxes) {
  by_volume_ = surface.empty() || !mission.coverage_counts_surface;
  if (by_volume_) {
    double volume = 0;
    for (const Box& b : boxes_) volume += b.volume();
    total_ = static_cast<std::size_t>(volume / std::pow(resolution_m_, 3));
    return;
  }
  for (const Vec3& p : surface) surface_.emplace(voxel_number(voxel_at(p, resolution_m_)), false);
  total_ = surface_.size();
}

void Coverage::received(const store::Record& record) {
  // The same record comes by many ways.
  auto& newest = newest_[{record.header.author.robot, record.header.key}];
  if (record.header.version() <= newest) return;
  const auto body = dds::decode_body<mission::MapBlock>(record);
  for (const map::SaidBlock& block : dds::said_blocks(body, resolution_m_)) {
    for (int i = 0; i < map::kBlockVoxels; ++i) {
      const bool is_occupied = map::bit(block.said.occupied, i);
      if (by_volume_ && (is_occupied || map::bit(block.said.free, i)))
        known(map::voxel_in(block.key, i));
      else if (is_occupied)
        occupied(map::voxel_in(block.key, i));
    }
  }
  newest = record.header.version();
}

void Coverage::occupied(map::VoxelKey k) {
  static constexpr int kNear[7][3] = {{0, 0, 0},  {1, 0, 0}, {-1, 0, 0}, {0, 1, 0},
                                      {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  for (const auto& d : kNear) {
    const auto it = surface_.find(voxel_number({k.x + d[0], k.y + d[1], k.z + d[2]}));
    if (it == surface_.end() || it->second) continue;
    it->second = true;
    ++covered_;
  }
}

void Coverage::known(map::VoxelKey k) {
  const Vec3 p = center(k, resolution_m_);
  const bool inside =
      std::any_of(boxes_.begin(), boxes_.end(), [&](const Box& b) { return b.contains(p); });
  if (inside && known_.insert(voxel_number(k)).second) ++covered_;
}

void Coverage::station_lost_all() {
  for (auto& [voxel, covered] : surface_) covered = false;
  known_.clear();
  newest_.clear();
  covered_ = 0;
}

double Coverage::share() const {
  if (total_ == 0) return 1;
  return std::min(1.0, static_cast<double>(covered_) / static_cast<double>(total_));
}

}  // namespace muster::world
