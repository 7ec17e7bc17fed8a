#include <octomap/OcTree.h>

#include <catch2/catch.hpp>

#include "tests/unit/map/toy_world.h"

using namespace muster;
using namespace muster::map;

namespace {

const toy::World kEmpty;
const toy::World kRoom{{{{-10, -10, -1}, {10, 10, 0}},     // floor
                        {{3, -10, 0}, {3.4, 10, 4}},       // wall ahead
                        {{1.5, 0.5, 0}, {1.7, 0.7, 3}}}};  // a column before it
const Pose kEye{{0.05, 0.03, 1.51}, 0};

Voxel state(const octomap::OcTree& tree, const Vec3& p) {
  const auto* node = tree.search(p.x(), p.y(), p.z());
  return !node ? Voxel::kUnknown : tree.isNodeOccupied(node) ? Voxel::kOccupied : Voxel::kFree;
}

}  // namespace

TEST_CASE("one scan makes free what rays pass and occupied what they meet") {
  VoxelMap m(toy::config());
  const auto done = toy::see(m, kRoom, kEye);
  CHECK(done.changed > 1000);
  CHECK(done.unexplained.empty());
  CHECK(m.at(Vec3(1, 0, 1.5)) == Voxel::kFree);
  CHECK(m.at(Vec3(2.9, 0, 1.5)) == Voxel::kFree);
  CHECK(m.at(Vec3(3.1, 0, 1.5)) == Voxel::kOccupied);
  CHECK(m.at(Vec3(1.5, 0.5, 1.5)) == Voxel::kOccupied);
  CHECK(m.at(Vec3(3.5, 0, 1.5)) == Voxel::kUnknown);
  CHECK(m.at(Vec3(2.5, 0.9, 1.5)) == Voxel::kUnknown);  // behind the column
  CHECK(m.at(Vec3(-1, 0, 1.5)) == Voxel::kUnknown);
  CHECK(m.line_of_sight(kEye.p, {2.9, 0, 1.5}, false));
  CHECK_FALSE(m.line_of_sight(kEye.p, {3.9, 0, 1.5}, true));
  CHECK_FALSE(m.line_of_sight(kEye.p, {-2, 0, 1.5}, false));
  CHECK(m.line_of_sight(kEye.p, {-2, 0, 1.5}, true));
  CHECK(m.clearance({2.5, 0.01, 1.5}, 1) == Approx(0.5).margin(0.011));
}

TEST_CASE("a ray without return frees as far as it reaches and no measurement says nothing") {
  VoxelMap m(toy::config());
  toy::see(m, kEmpty, kEye);
  CHECK(m.at(Vec3(4.7, 0, 1.5)) == Voxel::kFree);
  CHECK(m.at(Vec3(5.3, 0, 1.5)) == Voxel::kUnknown);
  VoxelMap silent(toy::config());
  toy::Shot shot = toy::shoot(kEmpty, kEye);
  std::fill(shot.range_mm.begin(), shot.range_mm.end(), std::uint16_t{65535});
  CHECK(shot.into(silent).changed == 0);
  CHECK(silent.revision() == 0);
}

TEST_CASE("nothing outside the bounds is mapped but their skin") {
  MapConfig c = toy::config();
  c.bounds = Box{{1, 0, 1.5}, {3, 2, 2}, 0.4};
  VoxelMap m(c);
  toy::fly_randomly(m, kRoom, 20, 3);
  std::size_t known = 0, outside = 0;
  toy::for_each_voxel([&](VoxelKey k) {
    if (m.at(k) == Voxel::kUnknown) return;
    ++known;
    outside += !c.bounds.contains(m.center(k), 0.2 + 1e-6);
  });
  CHECK(known > 300);
  CHECK(outside == 0);
}

TEST_CASE("a return from a teammate is neither mapped nor traced beyond") {
  const toy::World with_mate{{{{2.0, -0.25, 1.25}, {2.5, 0.25, 1.75}}}};
  VoxelMap m(toy::config());
  const Sphere mate{{2.3, 0.1, 1.5}, 0.25};  // where it says it is, somewhat off
  toy::see(m, with_mate, kEye, {}, 0, nullptr, {&mate, 1});
  CHECK(m.at(Vec3(1.2, 0, 1.5)) == Voxel::kFree);
  CHECK(m.at(Vec3(2.1, 0, 1.5)) != Voxel::kOccupied);
  CHECK(m.at(Vec3(3.1, 0, 1.5)) == Voxel::kUnknown);
}

TEST_CASE("a body that passes is reported and not mapped, one that stays becomes map") {
  const toy::World body{{{{2.0, -0.2, 1.3}, {2.4, 0.2, 1.7}}}};
  VoxelMap m(toy::config());
  for (int i = 0; i < 3; ++i) toy::see(m, kEmpty, kEye, {}, 0.5 * i);
  for (int i = 0; i < 3; ++i) {
    const auto done = toy::see(m, body, kEye, {}, 1.5 + 0.5 * i);
    CHECK(done.unexplained.size() > 5);
    CHECK((done.unexplained.front() - Vec3(2.0, 0, 1.5)).norm() < 0.6);
    CHECK(m.at(Vec3(2.1, 0.01, 1.5)) == Voxel::kFree);
  }
  for (int i = 3; i < 8; ++i) toy::see(m, body, kEye, {}, 1.5 + 0.5 * i);
  CHECK(m.at(Vec3(2.1, 0.01, 1.5)) == Voxel::kOccupied);
  CHECK(toy::see(m, body, kEye, {}, 6).unexplained.empty());
  for (int i = 0; i < 10; ++i) toy::see(m, kEmpty, kEye, {}, 7 + 0.5 * i);
  CHECK(m.at(Vec3(2.1, 0.01, 1.5)) == Voxel::kFree);
}

TEST_CASE("the OcTree holds the own evidence at every voxel, however late it is written") {
  VoxelMap m(toy::config()), asked(toy::config());
  for (int part = 0; part < 15; ++part) {
    for (VoxelMap* map : {&m, &asked}) {
      if (part == 0) map->insert_free_ball({0, 0, 1.5}, 1.5);
      toy::fly_randomly(*map, kRoom, 2, static_cast<std::uint64_t>(part));
    }
    asked.own();
  }
  const octomap::OcTree& tree = m.own();
  std::size_t known = 0, wrong = 0;
  toy::for_each_voxel([&](VoxelKey k) {
    wrong += state(tree, m.center(k)) != m.at(k);
    known += m.at(k) != Voxel::kUnknown;
  });
  CHECK(wrong == 0);
  CHECK(known > 10'000);
  CHECK(tree == asked.own());
  // As small as OctoMap's own pruning makes it, with its count of nodes right.
  octomap::OcTree copy(tree);
  CHECK(copy.calcNumNodes() == tree.size());
  copy.prune();
  CHECK(copy.size() == tree.size());
}

TEST_CASE("a noiseless scan leaves the occupancy that OctoMap's insertPointCloud leaves") {
  // Every ray meets something, away from voxel faces, so that both read the scan alike.
  const toy::World shell{{{{-4, -4, -1}, {4, 4, -0.1}},
                          {{3.06, -4, -1}, {4, 4, 5}},
                          {{-4, 2.06, -1}, {4, 4, 5}},
                          {{-4, -4, -1}, {4, -2.06, 5}},
                          {{-4, -4, 3.06}, {4, 4, 5}}}};
  VoxelMap m(toy::config());
  toy::Shot shot = toy::shoot(shell, kEye);
  shot.into(m);
  octomap::Pointcloud cloud;
  for (std::size_t i = 0; i < shot.range_mm.size(); ++i) {
    const double az = shot.scan.hfov_rad * (0.5 - (static_cast<double>(i % 48) + 0.5) / 48);
    const double el = shot.scan.vfov_rad * ((static_cast<double>(i / 48) + 0.5) / 31 - 0.5);
    const Vec3 p = kEye.p + shot.range_mm[i] * 1e-3 * ray_direction(0, 0, az, el);
    cloud.push_back(
        octomap::point3d(p.cast<float>().x(), p.cast<float>().y(), p.cast<float>().z()));
  }
  octomap::OcTree reference(0.2);
  reference.insertPointCloud(cloud, octomap::point3d(0.05f, 0.03f, 1.51f));
  std::size_t same = 0, differ = 0;
  toy::for_each_voxel([&](VoxelKey k) {
    const Voxel theirs = state(reference, m.center(k));
    if (theirs != Voxel::kUnknown || m.at(k) != Voxel::kUnknown)
      ++(theirs == m.at(k) ? same : differ);
  });
  INFO(same << " same, " << differ << " differ");
  CHECK(same > 3000);
  // Where a return lies within 3 cm of a voxel's face, ours is put behind the surface.
  CHECK(differ * 50 < same);
}

TEST_CASE("noise neither closes a gap nor opens a wall nor leaves ghosts") {
  // A wall with a door 1 m wide, seen from many places.
  const toy::World wall{{{{3.05, -6, -0.5}, {3.25, -0.5, 4}}, {{3.05, 0.5, -0.5}, {3.25, 6, 4}}}};
  VoxelMap m(toy::config());
  Random random(11, RobotId{1}, "noise");
  for (int i = 0; i < 80; ++i) {
    const Vec3 p(random.uniform(-1.5, 2), random.uniform(-2, 2), random.uniform(1, 2));
    toy::see(m, wall, {p, random.uniform(-0.5, 0.5)}, toy::Sensor::noisy(), 0.5 * i, &random);
  }
  int holes = 0, ghosts = 0, closed = 0;
  for (int z = 5; z < 10; ++z) {
    for (int y = -8; y < 8; ++y) {
      const bool door = y >= -2 && y < 2;
      const bool wall_seen = m.at(VoxelKey{15, y, z}) == Voxel::kOccupied ||
                             m.at(VoxelKey{16, y, z}) == Voxel::kOccupied;
      if (!door && std::abs(y + 0.5) > 3.5 && !wall_seen) ++holes;
      if (door && m.at(VoxelKey{15, y, z}) != Voxel::kFree) ++closed;
      for (int x = 0; x < 14; ++x) ghosts += m.at(VoxelKey{x, y, z}) == Voxel::kOccupied;
    }
  }
  CHECK(holes == 0);
  CHECK(closed == 0);
  CHECK(ghosts == 0);
}

TEST_CASE("a stray return in space seen free makes no wall") {
  VoxelMap m(toy::config());
  for (int i = 0; i < 3; ++i) toy::see(m, kEmpty, kEye, {}, 0.5 * i);
  toy::Shot stray = toy::shoot(kEmpty, kEye, {}, 2);
  for (std::size_t i = 700; i < 704; ++i) stray.range_mm[i] = 3000;
  stray.into(m);
  const auto all = toy::states(m);
  CHECK(std::count(all.begin(), all.end(), Voxel::kOccupied) == 0);
}
