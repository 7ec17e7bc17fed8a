#include <octomap/OcTree.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "common/core/error.h"
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
  for (const BlockKey k : keys) to.merge(author, k, from.encode_own(k));
}

std::vector<Voxel> all_of(Voxel v) { return std::vector<Voxel>(4096, v); }

}  // namespace

TEST_CASE("others' blocks merge to the same map in any order, newest per author") {
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
  m.merge(RobotId{4}, b, encode_block(all_of(Voxel::kOccupied)));
  m.merge(RobotId{5}, b, encode_block(all_of(Voxel::kFree)));
  CHECK(m.at(Vec3(1, 0.1, 1.5)) == Voxel::kFree);
  CHECK(m.at(Vec3(3.1, 0.1, 1.5)) == Voxel::kOccupied);
  CHECK(m.at(Vec3(0.1, 3, 1.5)) == Voxel::kOccupied);  // unknown to us, one says occupied
  m.merge(RobotId{4}, b, encode_block(all_of(Voxel::kUnknown)));
  CHECK(m.at(Vec3(0.1, 3, 1.5)) == Voxel::kFree);
}

TEST_CASE("blocks survive the wire and damaged ones are refused") {
  Random random(2, RobotId{1}, "blocks");
  std::vector<Voxel> voxels;
  for (int i = 0; i < 4096; ++i) voxels.push_back(static_cast<Voxel>(random.below(3)));
  const Bytes bytes = encode_block(voxels);
  CHECK(decode_block(bytes) == voxels);
  CHECK(encode_block(all_of(Voxel::kFree)).size() < 40);
  CHECK_THROWS_AS(decode_block({}), BadInput);
  CHECK_THROWS_AS(decode_block(ByteView(bytes).first(bytes.size() / 2)), BadInput);
  CHECK_THROWS_AS(decode_block(encode_block(std::vector<Voxel>(4096, Voxel{3}))), BadInput);
  int decoded = 0, refused = 0;
  for (int i = 0; i < 2000; ++i) {
    Bytes bad = bytes;
    for (int n = 0; n < 3; ++n)
      bad[random.below(bad.size())] ^= static_cast<std::uint8_t>(1 + random.below(255));
    try {
      decoded += decode_block(bad).size() == 4096;
    } catch (const BadInput&) {
      ++refused;
    }
  }
  CHECK(decoded + refused == 2000);
  CHECK(refused > 100);
  VoxelMap m(toy::config());
  CHECK_THROWS_AS(m.merge(RobotId{1}, {1 << 22, 0, 0}, bytes), BadInput);
  m.merge(RobotId{1}, {1000, 0, 0}, bytes);  // out of bounds: nothing to keep
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
  m.merge(RobotId{4}, {-2, 0, 0}, encode_block(all_of(Voxel::kOccupied)));
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
