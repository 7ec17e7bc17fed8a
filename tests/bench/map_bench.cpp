// What mapping costs: the same flight past walls and columns, by VoxelMap and by OctoMap's own
// insertPointCloud; and what telling others of it costs, by our code and by zstd.
#include <octomap/OcTree.h>
#include <zstd.h>

#include <cstdio>
#include <ctime>

#include "common/map/block_codec.h"
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

using Words = std::vector<SaidBlock>;

/// What has changed since the cursor.
Words news(VoxelMap& map, std::uint64_t& cursor) {
  Words words;
  for (const BlockKey& key : map.own_changes(cursor)) {
    if (auto block = map.news(key)) words.push_back(*block);
  }
  for (const SaidBlock& block : words) map.told(block);
  return words;
}

/// The same words as planes of bits, packed by zstd.
std::size_t zstd_bytes(const Words& words) {
  const std::size_t plain = words.size() * sizeof(SaidBlock);
  Bytes packed(ZSTD_compressBound(plain));
  return ZSTD_compress(packed.data(), packed.size(), words.data(), plain, 3);
}

void compare(const char* name, const std::vector<Words>& records) {
  std::size_t blocks = 0, ours = 0, theirs = 0;
  std::vector<Bytes> codes;
  const double t0 = cpu_ms();
  for (const Words& words : records) codes.push_back(encode_blocks(words));
  const double t1 = cpu_ms();
  for (const Bytes& code : codes) blocks += decode_blocks(code).size();
  const double t2 = cpu_ms();
  for (const Words& words : records) theirs += zstd_bytes(words);
  const double t3 = cpu_ms(), n = static_cast<double>(blocks);
  for (const Bytes& code : codes) ours += code.size();
  std::printf(
      "%s %6.1f bytes a block, %.0f us to write and %.0f to read; zstd %.1f times as many "
      "bytes, %.0f us\n",
      name, static_cast<double>(ours) / n, 1e3 * (t1 - t0) / n, 1e3 * (t2 - t1) / n,
      static_cast<double>(theirs) / static_cast<double>(ours), 1e3 * (t3 - t2) / n);
}

/// All that the map has seen, as it is told who has heard nothing: 64 blocks a record.
std::vector<Words> all_of(const VoxelMap& map) {
  std::vector<Words> records;
  std::uint64_t cursor = 0;
  for (const BlockKey& key : map.own_changes(cursor)) {
    if (records.empty() || records.back().size() == 64) records.emplace_back();
    records.back().push_back(map.own_block(key));
  }
  return records;
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
  std::vector<Words> told;
  std::uint64_t cursor = 0;
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
    if (i % 10 == 9) told.push_back(news(map, cursor));
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
  compare("all in one go      ", all_of(map));
  compare("news every 5 s     ", told);
}
