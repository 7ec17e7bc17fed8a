#include "common/robot/map_sharer.h"

namespace muster::robot {
namespace {

constexpr double kBlockPeriod_s = 5.0;
constexpr double kLookPeriod_s = 3.0;
constexpr int kBlocksPerTick = 48;

}  // namespace

void MapSharer::step(Knowledge& k) {
  const SimTime now = k.now();
  bool company = false;
  for (const auto& [id, mate] : k.teammates()) company = company || k.in_contact(id);
  if (!company) {
    met_ = false;
    behind_ = false;
    return;
  }
  if (!met_ || (now - looked_).s() >= kLookPeriod_s) {
    for (const map::BlockKey& b : k.map().own_changes(cursor_)) pending_[b] = true;
    looked_ = now;
    met_ = true;
  }
  int written = 0;
  behind_ = false;
  for (auto it = pending_.begin(); it != pending_.end();) {
    const auto last = published_.find(it->first);
    if (last != published_.end() && (now - last->second).s() < kBlockPeriod_s) {
      ++it;
      continue;
    }
    if (written++ == kBlocksPerTick) {
      behind_ = true;
      break;
    }
    mission::MapBlock block;
    block.ix = it->first.x;
    block.iy = it->first.y;
    block.iz = it->first.z;
    block.resolution_m = static_cast<float>(k.mission().resolution_m);
    block.encoding = mission::BlockEncoding::kZstd2Bit;
    block.voxels = k.map().encode_own(it->first);
    k.publish(store::RecordClass::kMap, map::pack(it->first), block);
    published_[it->first] = now;
    it = pending_.erase(it);
  }
}

}  // namespace muster::robot
