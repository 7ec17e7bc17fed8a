#pragma once

#include <vector>

#include "common/map/voxel_map.h"

namespace muster::map {

/// How far a measured range may be from the truth: the depth camera's bound of 5 % and 2 cm.
double range_error_m(double range_m);

/// What one scan says about each voxel near the sensor, before it meets the map. Space that many
/// rays share is noted once.
enum Mark : std::uint8_t {
  kMiss = 1,      ///< a ray left it well before anything it may have hit
  kNearMiss = 2,  ///< a ray left it, within the error of what it hit
  kHit = 4,
  kFarHit = 8,  ///< hit from so far that the noise is as large as a voxel
};

/// A box of voxels around the sensor with one byte of marks each, and the list of those marked.
/// Reused from scan to scan.
class ScanMarks {
 public:
  /// Empties the marks and centres the box for a sensor at `grid_origin` (in voxels) that reaches
  /// `reach` voxels, `reach_z` up and down.
  void begin(const Vec3& grid_origin, int reach, int reach_z);
  void hit(VoxelKey k, Mark mark) { mark_at(index(k), mark); }
  /// Marks what the ray passes through: misses up to `sure` voxel edges from the origin, near
  /// misses up to `end`. A voxel counts when the ray has left it again.
  void pass(const Vec3& unit_direction, double sure, double end);

  template <class Visit>  // (VoxelKey, marks)
  void for_each(Visit visit) const {
    for (const std::uint32_t i : touched_) visit(key(i), marks_[i]);
  }
  bool holds(VoxelKey k) const;

 private:
  std::uint32_t index(VoxelKey k) const {
    return static_cast<std::uint32_t>((k.x - low_.x) +
                                      nx_ * ((k.y - low_.y) + ny_ * (k.z - low_.z)));
  }
  VoxelKey key(std::uint32_t i) const {
    const int n = static_cast<int>(i);
    return {low_.x + n % nx_, low_.y + n / nx_ % ny_, low_.z + n / (nx_ * ny_)};
  }
  void mark_at(std::uint32_t i, Mark mark) {
    if (marks_[i] == 0) touched_.push_back(i);
    marks_[i] = static_cast<std::uint8_t>(marks_[i] | mark);
  }

  Vec3 origin_ = Vec3::Zero();
  VoxelKey low_;
  int nx_ = 0, ny_ = 0, nz_ = 0;
  std::vector<std::uint8_t> marks_;
  std::vector<std::uint32_t> touched_;
};

/// Directions of a scan's rays in the sensor's own frame (x along the optical axis), kept from scan
/// to scan.
class RayTable {
 public:
  const std::vector<Vec3>& directions(const RangeScan& scan);

 private:
  std::uint32_t columns_ = 0, rows_ = 0;
  double hfov_rad_ = 0, vfov_rad_ = 0;
  std::vector<Vec3> directions_;
};

}  // namespace muster::map
