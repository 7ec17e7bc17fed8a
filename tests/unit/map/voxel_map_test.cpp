#include <octomap/OcTree.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "common/core/error.h"
#include "tests/unit/map/said.h"
#include "tests/unit/map/toy_world.h"

using namespace muster;
using namespace muster::map;

namespace {

const toy::World kRoom{{{{-10, -10, -1}, {10, 10, 0}}, {{3, -10, 0}, {3.4, 10, 4}}}};
const Pose kEye{{0.05, 0.03, 1.51}, 0};

void give(VoxelMap& to, RobotId author, const VoxelMap& from, bool backwards) {
  std::uint64_t cursor = 0;
  auto keys = from.own_changes(cursor);
  CHECK(std::is_sorted(keys.begin(), keys.end()));
  CHECK(from.own_changes(cursor).empty());
  if (backwards) std::reverse(keys.begin(), keys.end());
  for (const BlockKey k : keys) to.merge(author, from.own_block(k));
}

}  // namespace

TEST_CASE("others' words merge to the same map in any order of authors") {
  VoxelMap a(toy::config()), b(toy::config());
  toy::fly_randomly(a, kRoom, 6, 21);
  VoxelMap one(toy::config()), two(toy::config());
  give(one, RobotId{1}, a, false);
  toy::fly_randomly(a, kRoom, 6, 22);
  toy::fly_randomly(b, kRoom, 6, 23);
  give(one, RobotId{1}, a, false);
  give(one, RobotId{2}, b, false);
  toy::fly_randomly(one, kRoom, 3, 24);
  toy::fly_randomly(two, kRoom, 3, 24);
  give(two, RobotId{2}, b, true);
  give(two, RobotId{1}, a, true);
  CHECK(toy::states(one) == toy::states(two));
  const auto revision = one.revision();
  give(one, RobotId{2}, b, true);
  CHECK(one.revision() == revision);
}

TEST_CASE("own evidence wins over what others say") {
  VoxelMap m(toy::config());
  toy::see(m, kRoom, kEye);
  const BlockKey b = block_of(m.key({1, 0.1, 1.5}));
  m.merge(RobotId{4}, said(b, Voxel::kOccupied));
  m.merge(RobotId{5}, said(b, Voxel::kFree));
  CHECK(m.at(Vec3(1, 0.1, 1.5)) == Voxel::kFree);
  CHECK(m.at(Vec3(3.1, 0.1, 1.5)) == Voxel::kOccupied);
  CHECK(m.at(Vec3(0.1, 3, 1.5)) == Voxel::kOccupied);  // unknown to us, one says occupied
  m.merge(RobotId{4}, said(b, Voxel::kUnknown));       // nothing: its word stands
  CHECK(m.at(Vec3(0.1, 3, 1.5)) == Voxel::kOccupied);
  m.merge(RobotId{4}, said(b, Voxel::kFree));
  CHECK(m.at(Vec3(0.1, 3, 1.5)) == Voxel::kFree);
}

TEST_CASE("the place of the own body stays free, whatever a teammate took it for") {
  VoxelMap m(toy::config());
  const Vec3 here(1.1, 1.1, 1.1);
  const BlockKey b = block_of(m.key(here));
  m.merge(RobotId{4}, said(b, Voxel::kOccupied));
  REQUIRE(m.at(here) == Voxel::kOccupied);
  m.insert_free_ball(here, 0.25);
  CHECK(m.at(here) == Voxel::kFree);
  m.merge(RobotId{5}, said(b, Voxel::kOccupied));
  CHECK(m.at(here) == Voxel::kFree);
}

TEST_CASE("news are what changes the picture of who has heard everything else") {
  VoxelMap m(toy::config());
  toy::see(m, kRoom, kEye);
  const BlockKey b = block_of(m.key({1, 0.1, 1.5}));
  const auto all = m.news(b);
  REQUIRE(all);
  CHECK(all->said.free == m.own_block(b).said.free);
  CHECK(all->said.occupied == m.own_block(b).said.occupied);
  m.merge(RobotId{4}, said(b, Voxel::kFree));  // only the surfaces are news now
  const auto surfaces = m.news(b);
  REQUIRE(surfaces);
  CHECK(count(surfaces->said.free) == 0);
  CHECK(surfaces->said.occupied == all->said.occupied);
  m.told(*surfaces);
  CHECK_FALSE(m.news(b));
  VoxelMap hearer(toy::config());
  hearer.merge(RobotId{4}, said(b, Voxel::kFree));
  hearer.merge(RobotId{1}, *surfaces);
  toy::for_each_voxel([&](VoxelKey k) {
    if (block_of(k) == b && m.at(k) == Voxel::kOccupied) CHECK(hearer.at(k) == Voxel::kOccupied);
  });
}

TEST_CASE("who was told something that the own map no longer believes is told so") {
  VoxelMap m(toy::config());
  toy::see(m, kRoom, kEye);
  const BlockKey b = block_of(m.key({1, 0.1, 1.5}));
  m.told(said(b, Voxel::kOccupied));
  m.merge(RobotId{4}, said(b, Voxel::kOccupied));  // who says the same does not matter
  const auto news = m.news(b);
  REQUIRE(news);
  CHECK(news->said.free == m.own_block(b).said.free);
  CHECK(count(news->said.occupied) == 0);
}

TEST_CASE("blocks out of bounds change nothing") {
  VoxelMap m(toy::config());
  m.merge(RobotId{1}, said({1000, 0, 0}, Voxel::kFree));
  m.told(said({1000, 0, 0}, Voxel::kFree));
  CHECK(m.revision() == 0);
}

TEST_CASE("block keys pack in order and back") {
  for (const BlockKey b :
       {BlockKey{0, 0, 0}, BlockKey{-1, 2, -3}, BlockKey{1048575, -1048576, 7}}) {
    CHECK(unpack_block(pack(b)) == b);
  }
  CHECK(pack({-1, 0, 0}) < pack({0, -5, 0}));
  CHECK(block_of({-1, 16, -17}) == BlockKey{-1, 1, -2});
}

TEST_CASE("the known volume of a watched box equals a count") {
  VoxelMap m(toy::config());
  const Box box{{1, 0.5, 1.5}, {5, 3, 3}, 0.7};
  const std::size_t w = m.watch(box);
  for (std::uint64_t round = 0; round < 4; ++round) {
    toy::fly_randomly(m, kRoom, 3, 30 + round);
    std::size_t known = 0, total = 0;
    toy::for_each_voxel([&](VoxelKey k) {
      if (!box.contains(m.center(k), 1e-9)) return;
      ++total;
      known += m.at(k) != Voxel::kUnknown;
    });
    CHECK(m.known_m3(w) == Approx(static_cast<double>(known) * 0.008));
    CHECK(m.volume_m3(w) == Approx(static_cast<double>(total) * 0.008));
  }
}

TEST_CASE("the change feed names every block that changed") {
  VoxelMap m(toy::config());
  std::uint64_t cursor = 0;
  auto before = toy::states(m);
  for (std::uint64_t round = 0; round < 5; ++round) {
    toy::fly_randomly(m, kRoom, 2, 40 + round);
    const auto after = toy::states(m);
    const auto fed = m.changes(cursor);
    std::size_t i = 0, missed = 0;
    toy::for_each_voxel([&](VoxelKey k) {
      if (before[i] != after[i]) missed += !std::binary_search(fed.begin(), fed.end(), block_of(k));
      ++i;
    });
    CHECK(missed == 0);
    before = after;
  }
  CHECK(m.changes(cursor).empty());
}

TEST_CASE("the merged map is written as an OctoMap file") {
  VoxelMap m(toy::config());
  toy::see(m, kRoom, kEye);
  m.merge(RobotId{4}, said({-2, 0, 0}, Voxel::kOccupied));
  const auto path = std::filesystem::temp_directory_path() / "muster_voxel_map_test.bt";
  m.write_bt(path);
  octomap::OcTree tree(path);
  std::filesystem::remove(path);
  for (const Vec3& p : {Vec3(1, 0, 1.5), Vec3(3.1, 0, 1.5), Vec3(-5, 1, 1)}) {
    const auto* node = tree.search(p.x(), p.y(), p.z());
    REQUIRE(node);
    CHECK(tree.isNodeOccupied(node) == (m.at(p) == Voxel::kOccupied));
  }
  CHECK_FALSE(tree.search(-3, 3, 6));
  CHECK_THROWS_AS(m.write_bt("/nowhere/at/all.bt"), Failure);
}
