#include "common/map/scan_marks.h"

#include <cmath>
#include <limits>

namespace muster::map {

double range_error_m(double range_m) { return 0.02 + 0.05 * range_m; }

void ScanMarks::begin(const Vec3& grid_origin, int reach, int reach_z) {
  for (const std::uint32_t i : touched_) marks_[i] = 0;
  touched_.clear();
  origin_ = grid_origin;
  const auto floor_int = [](double v) { return static_cast<int>(std::floor(v)); };
  low_ = {floor_int(grid_origin.x()) - reach, floor_int(grid_origin.y()) - reach,
          floor_int(grid_origin.z()) - reach_z};
  nx_ = ny_ = 2 * reach + 1;
  nz_ = 2 * reach_z + 1;
  const std::size_t needed =
      static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_) * static_cast<std::size_t>(nz_);
  if (marks_.size() < needed) marks_.resize(needed, 0);
}

bool ScanMarks::holds(VoxelKey k) const {
  return k.x >= low_.x && k.x < low_.x + nx_ && k.y >= low_.y && k.y < low_.y + ny_ &&
         k.z >= low_.z && k.z < low_.z + nz_;
}

void ScanMarks::pass(const Vec3& unit_direction, double sure, double end) {
  // Amanatides and Woo: distances to the next boundary per axis, smallest first.
  const int strides[3] = {1, nx_, nx_ * ny_};
  double next[3], delta[3];
  int stride[3];
  VoxelKey at;
  int* const cell[3] = {&at.x, &at.y, &at.z};
  for (int a = 0; a < 3; ++a) {
    const double o = origin_[a], d = unit_direction[a], base = std::floor(o);
    *cell[a] = static_cast<int>(base);
    stride[a] = d > 0 ? strides[a] : -strides[a];
    if (std::abs(d) < 1e-12) {
      next[a] = delta[a] = std::numeric_limits<double>::infinity();
    } else {
      delta[a] = 1 / std::abs(d);
      next[a] = (d > 0 ? base + 1 - o : o - base) * delta[a];
    }
  }
  std::uint32_t i = index(at);
  for (;;) {
    const int axis = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
    const double leaves = next[axis];
    if (leaves > end) return;
    mark_at(i, leaves <= sure ? kMiss : kNearMiss);
    i = static_cast<std::uint32_t>(static_cast<int>(i) + stride[axis]);
    next[axis] += delta[axis];
  }
}

const std::vector<Vec3>& RayTable::directions(const RangeScan& scan) {
  if (columns_ == scan.columns && rows_ == scan.rows && hfov_rad_ == scan.hfov_rad &&
      vfov_rad_ == scan.vfov_rad) {
    return directions_;
  }
  columns_ = scan.columns;
  rows_ = scan.rows;
  hfov_rad_ = scan.hfov_rad;
  vfov_rad_ = scan.vfov_rad;
  directions_.clear();
  for (std::uint32_t r = 0; r < rows_; ++r) {
    for (std::uint32_t c = 0; c < columns_; ++c) {
      const double az = hfov_rad_ * (0.5 - (c + 0.5) / columns_);
      const double el = vfov_rad_ * ((r + 0.5) / rows_ - 0.5);
      directions_.push_back(ray_direction(0, 0, az, el));
    }
  }
  return directions_;
}

}  // namespace muster::map
