#include "common/map/own_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/core/error.h"

namespace muster::map {
namespace {

constexpr std::uint16_t kNoReturn = 0, kNoMeasurement = 65535;  // as in bus.idl
constexpr double kTeammateMarginM = 0.35;
constexpr double kSkinM = 0.03;  // matter is behind the surface: a face on a voxel boundary belongs
                                 // to the voxel behind it
// What a level lidar sees free says that what stands on the ground does not reach so high: that is
// true of the layer above as well, and not of the one below, which the plane may just touch.
constexpr double kPlaneUpM = 0.05;
constexpr int kConfirmScans = 3;
constexpr Duration kConfirmTime{1'500'000};
constexpr Duration kForget{2'500'000};
constexpr std::uint64_t kSettledScans = 4;
constexpr int kBlocksWrittenPerScan = 4;

/// Distance along the ray at which it enters the sphere; infinity when it does not.
double entry(const Vec3& origin, const Vec3& direction, const Vec3& center, double radius_m) {
  const Vec3 to_center = center - origin;
  const double along = to_center.dot(direction);
  const double off2 = to_center.squaredNorm() - along * along, r2 = radius_m * radius_m;
  if (off2 > r2) return std::numeric_limits<double>::infinity();
  return std::max(0.0, along - std::sqrt(r2 - off2));
}

}  // namespace

OwnMap::OwnMap(const MapConfig& config, BlockStore& blocks)
    : config_(config), blocks_(blocks), tree_(config.resolution_m) {
  tree_.setClampingThresMin(octomap::probability(Weights::kFloor * double{kEvidenceStep}));
  tree_.setClampingThresMax(octomap::probability(Weights::kCeiling * double{kEvidenceStep}));
}

VoxelKey OwnMap::key(const Vec3& p) const {
  const Vec3 g = (p / config_.resolution_m).array() + 1e-9;
  return {static_cast<int>(std::floor(g.x())), static_cast<int>(std::floor(g.y())),
          static_cast<int>(std::floor(g.z()))};
}

VoxelMap::Integrated OwnMap::integrate(const RangeScan& scan, std::span<const Sphere> teammates) {
  MUSTER_CHECK(scan.range_mm.size() == std::size_t{scan.columns} * scan.rows);
  VoxelMap::Integrated result;
  ++scan_number_;
  suspected_now_.clear();
  confirmed_now_.clear();
  const double reach_m = scan.range_m + range_error_m(scan.range_m) + kSkinM;
  const double steepest =
      std::min(std::numbers::pi / 2, scan.vfov_rad / 2 + std::abs(scan.pitch_rad));
  const auto voxels = [&](double m) {
    return static_cast<int>(std::ceil(m / config_.resolution_m)) + 1;
  };
  Vec3 origin = scan.sensor.p;
  if (config_.ground && scan.rows == 1) origin.z() += kPlaneUpM;
  marks_.begin((origin / config_.resolution_m).array() + 1e-9, voxels(reach_m),
               voxels(reach_m * std::sin(steepest)));

  const double cy = std::cos(scan.sensor.yaw_rad), sy = std::sin(scan.sensor.yaw_rad);
  const double cp = std::cos(scan.pitch_rad), sp = std::sin(scan.pitch_rad);
  const std::vector<Vec3>& directions = rays_.directions(scan);
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const std::uint16_t mm = scan.range_mm[i];
    if (mm == kNoMeasurement) continue;
    const double measured_m = mm == kNoReturn ? std::numeric_limits<double>::infinity() : mm * 1e-3;
    if (mm != kNoReturn && measured_m > reach_m - kSkinM) continue;
    const Vec3& d = directions[i];
    const double x = cp * d.x() - sp * d.z(), z = sp * d.x() + cp * d.z();
    trace(origin, {cy * x - sy * d.y(), sy * x + cy * d.y(), z}, scan.range_m, measured_m,
          teammates, result, scan.time);
  }
  result.changed = apply_marks();
  forget_suspects(scan.time);
  blocks_.commit();
  write_settled_blocks();
  return result;
}

void OwnMap::trace(const Vec3& origin, const Vec3& direction, double range_m, double measured_m,
                   std::span<const Sphere> teammates, VoxelMap::Integrated& result, SimTime now) {
  const double edge = config_.resolution_m;
  if (!std::isfinite(measured_m)) {
    marks_.pass(direction, (range_m - range_error_m(range_m)) / edge, range_m / edge);
    return;
  }
  const Vec3 end = origin + measured_m * direction;
  for (const Sphere& s : teammates) {
    const double grown_m = s.radius_m + kTeammateMarginM;
    if ((end - s.center).squaredNorm() > grown_m * grown_m) continue;
    const double clear = std::min(entry(origin, direction, s.center, grown_m), measured_m) / edge;
    marks_.pass(direction, clear, clear);
    return;
  }
  const Vec3 spot = end + kSkinM * direction;
  const VoxelKey k = key(spot);
  if (unexplained(k, spot, direction, measured_m) && !confirmed(k, now)) {
    result.unexplained.push_back(end);
    const double clear = (measured_m - 2 * edge) / edge;
    marks_.pass(direction, clear, clear);
    return;
  }
  if (marks_.holds(k)) marks_.hit(k, measured_m > Weights::kFarM ? kFarHit : kHit);
  // Never into the hit voxel itself: a voxel counts when the ray has left it, and the skin is
  // behind the surface.
  marks_.pass(direction, (measured_m - range_error_m(measured_m)) / edge,
              (measured_m + kSkinM) / edge);
}

Evidence OwnMap::evidence(VoxelKey k) const {
  const Block* b = blocks_.find(block_of(k));
  return b && b->own ? b->own->evidence[static_cast<std::size_t>(local_index(k))] : kNoEvidence;
}

bool OwnMap::unexplained(VoxelKey k, const Vec3& spot, const Vec3& direction,
                         double measured_m) const {
  const auto sure_free = [](Evidence e) { return e != kNoEvidence && e <= 2 * Weights::kMiss; };
  if (!sure_free(evidence(k))) return false;
  for (int i = 0; i < 27; ++i) {
    const Evidence e = evidence({k.x + i % 3 - 1, k.y + i / 3 % 3 - 1, k.z + i / 9 - 1});
    if (e == kNoEvidence || e >= 0) return false;
  }
  // Noise may have put the return of a surface a little behind in front of it.
  const double error_m = range_error_m(measured_m) + config_.resolution_m;
  const double step_m = config_.resolution_m / 2;
  for (int i = 2; i * step_m < error_m + config_.resolution_m; ++i) {
    const Evidence e = evidence(key(spot + i * step_m * direction));
    if (e == kNoEvidence || e >= 0) return false;
  }
  return true;
}

bool OwnMap::confirmed(VoxelKey k, SimTime now) {
  const auto listed = [&](const std::vector<VoxelKey>& v) {
    return std::find(v.begin(), v.end(), k) != v.end();
  };
  if (listed(confirmed_now_)) return true;
  if (listed(suspected_now_)) return false;
  Suspect& s = suspects_.try_emplace(k, Suspect{now, now, 0}).first->second;
  s.last = now;
  ++s.scans;
  const bool stays = s.scans >= kConfirmScans && now - s.first >= kConfirmTime;
  (stays ? confirmed_now_ : suspected_now_).push_back(k);
  return stays;
}

void OwnMap::forget_suspects(SimTime now) {
  for (const VoxelKey& k : confirmed_now_) suspects_.erase(k);
  std::erase_if(suspects_, [&](const auto& entry) { return now - entry.second.last > kForget; });
}

std::uint32_t OwnMap::apply_marks() {
  std::uint32_t changed = 0;
  Block* block = nullptr;
  BlockKey block_key{std::numeric_limits<int>::max(), 0, 0};
  marks_.for_each([&](VoxelKey k, std::uint8_t marks) {
    const BlockKey b = block_of(k);
    if (b != block_key) {
      block_key = b;
      block = blocks_.obtain(b);
    }
    if (block && apply(*block, local_index(k), marks)) ++changed;
  });
  // What stayed where free space was believed is mapped at once, whatever the evidence was.
  for (const VoxelKey& k : confirmed_now_) {
    Block* b = blocks_.obtain(block_of(k));
    if (b && set_evidence(*b, local_index(k), Weights::kHit)) ++changed;
  }
  return changed;
}

bool OwnMap::apply(Block& block, int i, std::uint8_t marks) {
  const Evidence old = block.own ? block.own->evidence[static_cast<std::size_t>(i)] : kNoEvidence;
  int step;
  if (marks & kHit) {
    step = Weights::kHit;
  } else if (marks & kFarHit) {
    step = Weights::kFarHit;
  } else if (old >= 0 && !(marks & kMiss)) {
    step = Weights::kNearMiss;
  } else {
    step = Weights::kMiss;
  }
  const int value =
      std::clamp((old == kNoEvidence ? 0 : int{old}) + step, Weights::kFloor, Weights::kCeiling);
  return value != old && set_evidence(block, i, value);
}

bool OwnMap::set_evidence(Block& block, int i, int value) {
  if (!block.mapped(i)) return false;
  if (!block.own) block.own = std::make_unique<OwnBlock>();
  OwnBlock& own = *block.own;
  own.evidence[static_cast<std::size_t>(i)] = static_cast<Evidence>(value);
  block.touched_scan = scan_number_;
  if (!block.in_tree_queue) tree_queue_.push_back(&block);
  block.in_tree_queue = true;
  const bool occupied = value >= 0;
  if (bit(own.states.occupied, i) == occupied && bit(own.states.free, i) == !occupied) return false;
  put(own.states.occupied, i, occupied);
  put(own.states.free, i, !occupied);
  blocks_.own_changed(block);
  return blocks_.set_merged(block, i, occupied ? Voxel::kOccupied : Voxel::kFree);
}

void OwnMap::insert_free(VoxelKey k) {
  Block* b = blocks_.obtain(block_of(k));
  if (b && evidence(k) == kNoEvidence) set_evidence(*b, local_index(k), Weights::kMiss);
}

void OwnMap::clear(VoxelKey k) {
  Block* b = blocks_.obtain(block_of(k));
  if (b && (evidence(k) == kNoEvidence || evidence(k) >= 0))
    set_evidence(*b, local_index(k), Weights::kMiss);
}

void OwnMap::adopt(Block& block, const States& states) {
  for (int i = 0; i < kBlockVoxels; ++i) {
    const bool occupied = bit(states.occupied, i);
    if (!occupied && !bit(states.free, i)) continue;
    if (block.own && block.own->evidence[static_cast<std::size_t>(i)] != kNoEvidence) continue;
    set_evidence(block, i, occupied ? Weights::kHit : Weights::kMiss);
  }
}

void OwnMap::write_to_tree(Block& block) {
  write_block(tree_, block.key, block.own->evidence);
  block.in_tree_queue = false;
}

void OwnMap::write_settled_blocks() {
  int budget = kBlocksWrittenPerScan;
  std::erase_if(tree_queue_, [&](Block* b) {
    if (budget == 0 || b->touched_scan + kSettledScans > scan_number_) return false;
    --budget;
    write_to_tree(*b);
    return true;
  });
}

const octomap::OcTree& OwnMap::tree() {
  for (Block* b : tree_queue_) write_to_tree(*b);
  tree_queue_.clear();
  return tree_;
}

}  // namespace muster::map
