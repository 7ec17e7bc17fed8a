#pragma once

#include <map>
#include <memory>
#include <vector>

#include "common/map/block_store.h"
#include "common/map/own_tree.h"
#include "common/map/scan_marks.h"

namespace muster::map {

/// How observations weigh, in evidence steps of 0.05 log-odds.
///
/// One observation decides an unknown voxel. Hits outweigh misses, since a ray that grazes a thin
/// thing passes it more often than not. A well seen free voxel (−24) needs two near hits or three
/// far ones to become occupied, so a stray return makes no wall; a surface (50) falls after seven
/// scans that clearly see through it. Near misses, which the sensor's noise alone can explain,
/// hardly count against a voxel that was hit.
struct Weights {
  static constexpr int kHit = 17, kFarHit = 9, kMiss = -8, kNearMiss = -2, kFloor = -24,
                       kCeiling = 50;
  static constexpr double kFarM = 3.5;
};

/// The robot's own evidence: integrates scans into the blocks' evidence and, in batches, into the
/// OcTree.
class OwnMap {
 public:
  OwnMap(const MapConfig& config, BlockStore& blocks);

  VoxelMap::Integrated integrate(const RangeScan& scan, std::span<const Sphere> teammates);
  void insert_free(VoxelKey k);
  /// Free, whatever has been seen there.
  void clear(VoxelKey k);
  /// Evidence of an earlier start, where nothing is known yet.
  void adopt(Block& block, const States& states);
  const octomap::OcTree& tree();

 private:
  /// A return where the own map is sure of free space: a body passing by, or a thin thing that was
  /// missed.
  struct Suspect {
    SimTime first, last;
    int scans = 0;
  };
  struct Ray {
    double measured_m = 0;  ///< infinity: nothing returned
    Vec3 direction;
  };

  void trace(const Vec3& origin, const Vec3& direction, double range_m, double measured_m,
             std::span<const Sphere> teammates, VoxelMap::Integrated& result, SimTime now);
  bool unexplained(VoxelKey k, const Vec3& spot, const Vec3& direction, double measured_m) const;
  /// One more scan saw something there; true once it has stayed.
  bool confirmed(VoxelKey k, SimTime now);
  void forget_suspects(SimTime now);
  std::uint32_t apply_marks();
  bool apply(Block& block, int i, std::uint8_t marks);
  bool set_evidence(Block& block, int i, int value);
  Evidence evidence(VoxelKey k) const;
  void write_to_tree(Block& block);
  void write_settled_blocks();

  VoxelKey key(const Vec3& p) const;

  MapConfig config_;
  BlockStore& blocks_;
  octomap::OcTree tree_;
  ScanMarks marks_;
  RayTable rays_;
  std::map<VoxelKey, Suspect> suspects_;
  std::vector<VoxelKey> suspected_now_, confirmed_now_;
  std::vector<Block*> tree_queue_;
  std::uint64_t scan_number_ = 0;
};

}  // namespace muster::map
