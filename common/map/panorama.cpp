#include "common/map/panorama.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/map/visibility.h"
#include "common/map/voxel_reader.h"

namespace muster::map {
namespace {

constexpr int kRows = 6;
constexpr double kColumn_rad = 2 * std::numbers::pi / Panorama::kHeadings;
constexpr double kReliableRange = 0.93;  // of the camera's, as for viewpoints
constexpr double kReliableView = 0.94;   // of its angles
constexpr std::size_t kSample = 160;     // surface voxels looked for from one spot
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

/// Unknown volume in view within one column of the compass.
double PanoramaReader::column(const Vec3& eye, double yaw_rad, int column) const {
  const FieldOfView& fov = config_.camera;
  const double step_m = map_.config().resolution_m, range_m = kReliableRange * fov.range_m;
  const double row_rad = fov.vfov_rad / kRows;
  double unknown_m3 = 0;
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
      if (v == Voxel::kOccupied) break;
      if (v == Voxel::kUnknown) {
        if (!unknown_before && cells_.given_up(last)) break;
        unknown_before = true;
        if (cells_.unknown_in_box(k)) unknown_m3 += clear * d * d * step_m * solid_rad2;
        clear *= 1 - step_m / kHaze_m;
      }
      last = k;
    }
  }
  return unknown_m3;
}

/// Surface voxels within the height of the view from `eye` that are owed looks: a sample, and of
/// how many each stands for.
PanoramaReader::Sample PanoramaReader::owed_around(const Vec3& eye) const {
  const double range_m = std::min(config_.look_range_m, config_.camera.range_m);
  const double middle = std::tan(config_.pitch_rad);
  const double half = std::tan(kReliableView * config_.camera.vfov_rad / 2);
  Sample sample;
  std::vector<VoxelKey>& cells = sample.cells;
  cells_.near(cells_.owed(), eye, range_m, [&](VoxelKey k) {
    const Vec3 d = map_.center(k) - eye;
    const double flat = d.head<2>().norm();
    if (d.squaredNorm() <= range_m * range_m && std::abs(d.z() - flat * middle) <= flat * half)
      cells.push_back(k);
  });
  const std::size_t stride = (cells.size() + kSample - 1) / kSample;
  if (stride > 1) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < cells.size(); i += stride) cells[kept++] = cells[i];
    sample.stands_for = static_cast<double>(cells.size()) / static_cast<double>(kept);
    cells.resize(kept);
  }
  return sample;
}

/// What a look at this voxel from `eye` is worth, m².
double PanoramaReader::look_m2(VoxelKey k, const Vec3& eye) const {
  const Aim aim = surface_aim(cells_, k);
  const FaceSet seen = faces_sighted(map_, aim, eye, config_.look_range_m);
  double value = 0;
  for (std::size_t f = 0; f < 6; ++f) {
    if ((seen >> f & 1) != 0) value = std::max(value, aim.value[f]);
  }
  return value * map_.config().resolution_m * map_.config().resolution_m;
}

Panorama PanoramaReader::around(const Vec3& eye) const {
  std::array<Worth, Panorama::kHeadings> columns;
  for (int i = 0; i < Panorama::kHeadings; ++i)
    columns[static_cast<std::size_t>(i)].unknown_m3 = column(eye, i * kColumn_rad, i);
  const Sample owed = owed_around(eye);
  for (const VoxelKey& k : owed.cells) {
    const Vec3 d = map_.center(k) - eye;
    const int at = static_cast<int>(std::lround(std::atan2(d.y(), d.x()) / kColumn_rad));
    columns[static_cast<std::size_t>((at + Panorama::kHeadings) % Panorama::kHeadings)].owed_m2 +=
        owed.stands_for * look_m2(k, eye);
  }
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
    sum.unknown_m3 += column(pose.p, pose.yaw_rad + off, c);
  }
  const Sample owed = owed_around(pose.p);
  FieldOfView fov = config_.camera;
  fov.hfov_rad *= kReliableView;
  fov.vfov_rad *= kReliableView;
  for (const VoxelKey& k : owed.cells) {
    if (fov.contains(pose, config_.pitch_rad, map_.center(k)))
      sum.owed_m2 += owed.stands_for * look_m2(k, pose.p);
  }
  return sum;
}

}  // namespace muster::map
