#include "common/map/panorama.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/map/voxel_reader.h"

namespace muster::map {
namespace {

constexpr int kRows = 6;
constexpr double kColumn_rad = 2 * std::numbers::pi / Panorama::kHeadings;
constexpr double kReliableRange = 0.93;  // of the camera's, as for viewpoints
constexpr double kHaze_m = 4;            // unknown space is seldom empty: how far one sees into it

}  // namespace

PanoramaReader::PanoramaReader(const VoxelMap& map, const RegionCells& cells,
                               const TargetConfig& config)
    : map_(map),
      cells_(cells),
      config_(config),
      columns_in_view_(
          std::clamp(2 * static_cast<int>(std::lround(config.camera.hfov_rad / kColumn_rad / 2)), 2,
                     Panorama::kHeadings)) {}

Worth PanoramaReader::column(const Vec3& eye, double yaw_rad, int column) const {
  const FieldOfView& fov = config_.camera;
  const double step_m = map_.config().resolution_m, range_m = kReliableRange * fov.range_m;
  const double row_rad = fov.vfov_rad / kRows;
  Worth worth;
  VoxelReader reader(map_);
  for (int r = 0; r < kRows; ++r) {
    // Every other column between the rows of its neighbours, so that less slips through.
    const double el = fov.vfov_rad / 2 - (r + (column % 2 == 0 ? 0.3 : 0.7)) * row_rad;
    const Vec3 direction = ray_direction(yaw_rad, config_.pitch_rad, 0, el);
    const double solid_rad2 = kColumn_rad * row_rad * std::cos(el);
    VoxelKey last = map_.key(eye);
    double clear = 1;
    bool unknown_before = false;
    for (int i = 1; i * step_m < range_m; ++i) {
      const double d = i * step_m;
      const VoxelKey k = map_.key(eye + d * direction);
      const Voxel v = reader.at(k);
      if (v == Voxel::kOccupied) {
        if (!unknown_before && d <= config_.look_range_m)
          worth.owed_m2 += cells_.promise_from(k, eye) * d * d * solid_rad2;
        break;
      }
      if (v == Voxel::kUnknown) {
        if (!unknown_before && cells_.given_up(last)) break;
        unknown_before = true;
        if (cells_.unknown_in_box(k)) worth.unknown_m3 += clear * d * d * step_m * solid_rad2;
        clear *= 1 - step_m / kHaze_m;
      }
      last = k;
    }
  }
  return worth;
}

Panorama PanoramaReader::around(const Vec3& eye) const {
  std::array<Worth, Panorama::kHeadings> columns;
  for (int i = 0; i < Panorama::kHeadings; ++i)
    columns[static_cast<std::size_t>(i)] = column(eye, i * kColumn_rad, i);
  Panorama all;
  for (int i = 0; i < Panorama::kHeadings; ++i) {
    Worth& sum = all.headings[static_cast<std::size_t>(i)];
    for (int c = 0; c < columns_in_view_; ++c) {
      // An even number of columns lies around the border between two of them.
      const int at = (i + c - columns_in_view_ / 2 + Panorama::kHeadings) % Panorama::kHeadings;
      sum.unknown_m3 += columns[static_cast<std::size_t>(at)].unknown_m3;
      sum.owed_m2 += columns[static_cast<std::size_t>(at)].owed_m2;
    }
  }
  return all;
}

Worth PanoramaReader::at(const Pose& pose) const {
  Worth sum;
  for (int c = 0; c < columns_in_view_; ++c) {
    const double off = (c - (columns_in_view_ - 1) / 2.0) * kColumn_rad;
    const Worth w = column(pose.p, pose.yaw_rad + off, c);
    sum.unknown_m3 += w.unknown_m3;
    sum.owed_m2 += w.owed_m2;
  }
  return sum;
}

}  // namespace muster::map
