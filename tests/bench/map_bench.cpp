// What mapping costs: the same flight past walls and columns, by VoxelMap and by OctoMap's own
// insertPointCloud.
#include <octomap/OcTree.h>

#include <cstdio>
#include <ctime>

#include "common/map/targets.h"
#include "tests/unit/map/toy_world.h"

using namespace muster;
using namespace muster::map;

namespace {

double cpu_ms() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

toy::World site() {
  toy::World w{{{{-30, -30, -1}, {30, 30, 0}}}};
  for (int i = -4; i <= 4; ++i) {
    for (int j = -2; j <= 2; ++j) {
      const Vec3 at(4.0 * i + 0.3 * j, 5.0 * j + 2, 0);
      w.solids.push_back({at, at + Vec3(1.5 + 0.2 * j, 0.8, 3 + (i + 4) % 3)});
    }
  }
  return w;
}

octomap::Pointcloud cloud_of(const toy::Shot& shot) {
  octomap::Pointcloud cloud;
  for (std::size_t i = 0; i < shot.range_mm.size(); ++i) {
    const RangeScan& s = shot.scan;
    const double az = s.hfov_rad * (0.5 - (static_cast<double>(i % s.columns) + 0.5) / s.columns);
    const double el = s.vfov_rad * ((static_cast<double>(i / s.columns) + 0.5) / s.rows - 0.5);
    const double d =
        shot.range_mm[i] == 0 ? 20 : shot.range_mm[i] * 1e-3;  // no return: past the range
    const Vec3 p = s.sensor.p + d * ray_direction(s.sensor.yaw_rad, 0, az, el);
    cloud.push_back(
        octomap::point3d(p.cast<float>().x(), p.cast<float>().y(), p.cast<float>().z()));
  }
  return cloud;
}

}  // namespace

int main() {
  const toy::World world = site();
  MapConfig config;
  config.bounds = Box::from_corners({-18, -12, 0}, {18, 15, 8});
  VoxelMap map(config);
  map.insert_free_ball({-17, 0, 2}, 1.5);
  TargetConfig target_config;
  target_config.camera = {std::numbers::pi / 2, std::numbers::pi / 3, 5};
  Targets targets(map, Box::from_corners({-10, -10, 0.3}, {10, 12, 8}), target_config);
  octomap::OcTree reference(0.2);
  Random random(1, RobotId{1}, "bench");

  constexpr int kScans = 240;  // two minutes at 2 Hz
  double ours_ms = 0, theirs_ms = 0, targets_ms = 0, worst_ms = 0;
  for (int i = 0; i < kScans; ++i) {
    // Up and down the rows at 1.8 m/s, turning slowly.
    const double s = 0.9 * i, lap = 60;
    const double x = std::abs(std::fmod(s, lap) - lap / 2) - 15;
    const Pose pose{{x, -8.2 + 4.9 * std::floor(s / (lap / 2)) * 0.55, 1.2 + 0.5 * (i % 7)},
                    0.05 * i};
    toy::Shot shot = toy::shoot(world, pose, toy::Sensor::noisy(), 0.5 * i, &random);
    const octomap::Pointcloud cloud = cloud_of(shot);
    const double t0 = cpu_ms();
    shot.into(map);
    const double t1 = cpu_ms();
    reference.insertPointCloud(cloud,
                               octomap::point3d(pose.p.cast<float>().x(), pose.p.cast<float>().y(),
                                                pose.p.cast<float>().z()),
                               5.0);
    const double t2 = cpu_ms();
    targets.scanned(pose);
    if (i % 4 == 0) targets.looked(pose, 0);
    targets.update([](const Vec3&) { return true; });
    const double t3 = cpu_ms();
    ours_ms += t1 - t0;
    theirs_ms += t2 - t1;
    targets_ms += t3 - t2;
    worst_ms = std::max(worst_ms, t3 - t2);
  }
  const double t0 = cpu_ms();
  const std::size_t nodes = map.own().size();
  const double tree_ms = cpu_ms() - t0;
  std::printf("integrate           %6.3f ms per scan of 1488 rays (OcTree written within)\n",
              ours_ms / kScans);
  std::printf("insertPointCloud    %6.3f ms, %.1f times as much\n", theirs_ms / kScans,
              theirs_ms / ours_ms);
  std::printf("rest of the OcTree  %6.3f ms once, %zu nodes\n", tree_ms, nodes);
  std::printf("targets             %6.3f ms per update, worst %.3f ms, %zu viewpoints\n",
              targets_ms / kScans, worst_ms, targets.viewpoints().size());
}
