#include "commsim/world/activity.h"

#include <algorithm>
#include <cmath>

#include "commsim/world/coverage.h"

namespace muster::world {
namespace {

constexpr double kVoxelM = 0.2;
constexpr std::uint32_t kExploringVoxels = 50;
constexpr double kStillMps = 0.05;
constexpr int kRestTicks = 20;
constexpr std::uint64_t kTicksPerSecond = 10;
constexpr std::size_t kEvery = 2;  // every second column and row: neighbours share their voxels

}  // namespace

bool ActivityMeter::SeenVoxels::insert(map::VoxelKey k) {
  const std::uint64_t key = voxel_number({k.x >> 4, k.y >> 4, k.z >> 4});
  if (key != last_key_) {
    last_ = &blocks_.try_emplace(key, Block{}).first->second;
    last_key_ = key;
  }
  const auto bit = static_cast<std::size_t>((k.x & 15) | (k.y & 15) << 4 | (k.z & 15) << 8);
  std::uint64_t& word = (*last_)[bit / 64];
  const std::uint64_t mask = std::uint64_t{1} << (bit % 64);
  if (word & mask) return false;
  word |= mask;
  return true;
}

ActivityMeter::ActivityMeter(const mission::Mission& mission)
    : boxes_(mission.boxes), resolution_m_(kVoxelM) {
  std::vector<std::pair<RobotId, mission::Role>> roles;
  for (const auto& r : mission.fleet) roles.emplace_back(r.id, r.role);
  std::sort(roles.begin(), roles.end());
  robots_.resize(roles.size());
  for (std::size_t i = 0; i < roles.size(); ++i) robots_[i].role = roles[i].second;
}

void ActivityMeter::saw(std::size_t robot, const Vec3& from, const std::vector<Vec3>& ray_ends,
                        std::uint32_t columns) {
  Robot& r = robots_[robot];
  for (std::size_t i = 0; i < ray_ends.size(); i += kEvery) {
    if (i / columns % kEvery != 0) continue;
    const Vec3 way = ray_ends[i] - from;
    const int steps = static_cast<int>(std::floor(way.norm() / resolution_m_));
    const Vec3 step = way / std::max(1, steps);
    Vec3 p = from;
    for (int s = 0; s <= steps; ++s, p += step) {
      if (!r.seen.insert(voxel_at(p, resolution_m_))) continue;
      r.new_voxels +=
          std::any_of(boxes_.begin(), boxes_.end(), [&](const Box& b) { return b.contains(p); });
    }
  }
}

void ActivityMeter::tick(const std::vector<Doing>& robots) {
  ++ticks_;
  const bool second_ends = ticks_ % kTicksPerSecond == 0;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    Robot& r = robots_[i];
    if (!robots[i].alive) {
      r.second_ticks = r.pending_ticks = 0;
      continue;
    }
    ++r.second_ticks;
    switch (r.role) {
      case mission::Role::kStation:
        r.idle_ticks += robots[i].speed_mps < kStillMps;
        break;
      case mission::Role::kExplorer:
        tick_explorer(r, second_ends);
        break;
      case mission::Role::kInspector:
        tick_inspector(r, robots[i]);
        break;
    }
  }
}

void ActivityMeter::tick_explorer(Robot& r, bool second_ends) {
  if (!second_ends) return;
  if (r.new_voxels >= kExploringVoxels) {
    r.worked_ticks += r.second_ticks;
  } else {
    r.idle_ticks += r.second_ticks;
    r.waste_ticks += r.second_ticks;
  }
  r.new_voxels = 0;
  r.second_ticks = 0;
}

void ActivityMeter::tick_inspector(Robot& r, const Doing& doing) {
  if (doing.inspecting) {
    ++r.worked_ticks;
    r.pending_ticks = r.rest_ticks = 0;  // what came before was the way here
    return;
  }
  ++r.idle_ticks;
  r.rest_ticks = doing.speed_mps < kStillMps ? r.rest_ticks + 1 : 0;
  if (r.rest_ticks >= kRestTicks) {
    r.waste_ticks += r.pending_ticks + 1;
    r.pending_ticks = 0;
  } else {
    ++r.pending_ticks;
  }
}

ActivityMeter::Totals ActivityMeter::idle() const {
  Totals t;
  for (const Robot& r : robots_) {
    const double s = static_cast<double>(r.idle_ticks) / kTicksPerSecond;
    if (r.role == mission::Role::kStation) t.gcs_s += s;
    if (r.role == mission::Role::kExplorer) t.explorers_s += s;
    if (r.role == mission::Role::kInspector) t.inspectors_s += s;
  }
  return t;
}

ActivityMeter::Totals ActivityMeter::waste() const {
  Totals t;
  for (const Robot& r : robots_) {
    const double s = static_cast<double>(r.waste_ticks + r.pending_ticks) / kTicksPerSecond;
    if (r.role == mission::Role::kExplorer) t.explorers_s += s;
    if (r.role == mission::Role::kInspector) t.inspectors_s += s;
  }
  return t;
}

}  // namespace muster::world
