#pragma once

#include <vector>

#include "common/map/block.h"

namespace muster::map {

/// Where a body may be: turns a block and its 26 neighbours into its planes `traversable` and
/// `blocked`.
///
/// A voxel is blocked when the cube of an occupied one is within radius + clearance of its centre,
/// and traversable when it is not blocked and no unknown cube is within the radius. Both are
/// dilations of bit rows: a row of 16 voxels is moved as one number, so a block costs a few
/// microseconds and no counters are kept.
class Reach {
 public:
  /// Throws BadInput when the body is too large for the resolution.
  explicit Reach(const MapConfig& config);

  void refresh(Block& block) const;
  /// How many voxels away a change is felt.
  int radius_voxels() const { return radius_; }
  /// The layer of voxels that a UGV's centre moves in.
  int driving_layer() const { return driving_layer_; }
  /// Offsets (dx, dy, dz) whose occupation blocks a voxel; a UGV's includes all layers it must keep
  /// clear.
  const std::vector<VoxelKey>& blocking_offsets() const { return blocking_offsets_; }

 private:
  /// All voxels (dx, dy, dz) with |dx| ≤ half.
  struct Run {
    int dy, dz, half;
  };
  static std::vector<Run> runs(const MapConfig& config, double reach_m, int radius, int dz_low,
                               int dz_high);

  bool ground_;
  int radius_ = 0;
  int driving_layer_ = 0;
  std::vector<Run> occupied_runs_, unknown_runs_;
  std::vector<VoxelKey> blocking_offsets_;
};

}  // namespace muster::map
