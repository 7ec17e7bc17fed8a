#include <catch2/catch.hpp>

#include "common/map/region_cells.h"
#include "common/map/targets.h"
#include "common/map/visibility.h"
#include "tests/unit/map/toy_world.h"

using namespace muster;
using namespace muster::map;

namespace {

const toy::World kRoom{
    {{{-10, -10, -1}, {10, 10, 0}}, {{3.05, -4, 0}, {3.4, 4, 4}}, {{-2, 1.5, 0}, {1, 1.8, 2}}}};
const Box kTurned{{0.5, 0.3, 1.5}, {6, 5, 2.6}, 0.5};

bool beside(VoxelKey k, auto holds) {
  for (const VoxelKey& d : kFaces) {
    if (holds(VoxelKey{k.x + d.x, k.y + d.y, k.z + d.z})) return true;
  }
  return false;
}

Plane marks_of(const CellClusters& clusters, const RegionCells& cells, BlockKey b) {
  Plane result{};
  // `near` walks all slots within reach, so it reads the marks of one block by its voxels.
  cells.near(clusters, Vec3::Zero(), 100, [&](VoxelKey k) {
    if (block_of(k) == b) put(result, local_index(k), true);
  });
  return result;
}

}  // namespace

TEST_CASE("frontier and owed surface equal brute force after random updates") {
  VoxelMap m(toy::config());
  RegionCells cells(m, kTurned, 1, 2.5);
  const auto in_box = [&](VoxelKey k) { return kTurned.contains(m.center(k), 1e-9); };
  for (std::uint64_t round = 0; round < 6; ++round) {
    toy::fly_randomly(m, kRoom, 2, 70 + round);
    if (round == 3)
      m.merge(RobotId{3}, {0, 0, 0}, encode_block(std::vector<Voxel>(4096, Voxel::kFree)));
    cells.update();
    std::vector<VoxelKey> frontier, owed, frontier_found, owed_found;
    toy::for_each_voxel([&](VoxelKey k) {
      if (!in_box(k)) return;
      const auto unknown = [&](VoxelKey n) { return in_box(n) && m.at(n) == Voxel::kUnknown; };
      const auto free = [&](VoxelKey n) { return m.at(n) == Voxel::kFree; };
      if (m.at(k) == Voxel::kFree && beside(k, unknown)) frontier.push_back(k);
      if (m.at(k) == Voxel::kOccupied && m.center(k).z() >= 0.8 && beside(k, free))
        owed.push_back(k);
    });
    cells.near(cells.frontier(), Vec3::Zero(), 100,
               [&](VoxelKey k) { frontier_found.push_back(k); });
    cells.near(cells.owed(), Vec3::Zero(), 100, [&](VoxelKey k) { owed_found.push_back(k); });
    for (auto* list : {&frontier, &owed, &frontier_found, &owed_found})
      std::sort(list->begin(), list->end());
    CHECK(frontier.size() > 50);
    CHECK(frontier == frontier_found);
    CHECK(owed == owed_found);
  }
}

TEST_CASE("clusters hold every frontier voxel once, stay small and know their group") {
  VoxelMap m(toy::config());
  RegionCells cells(m, kTurned, 1, 1.6);
  for (std::uint64_t round = 0; round < 4; ++round) {
    toy::fly_randomly(m, kRoom, 2, 80 + round);
    cells.update();
    std::vector<VoxelKey> all, clustered;
    cells.near(cells.frontier(), Vec3::Zero(), 100, [&](VoxelKey k) { all.push_back(k); });
    for (const CellCluster& c : cells.frontier().clusters()) {
      VoxelKey low = c.cells[0], high = low;
      for (const VoxelKey& k : c.cells) {
        clustered.push_back(k);
        low = {std::min(low.x, k.x), std::min(low.y, k.y), std::min(low.z, k.z)};
        high = {std::max(high.x, k.x), std::max(high.y, k.y), std::max(high.z, k.z)};
      }
      CHECK(std::max({high.x - low.x, high.y - low.y, high.z - low.z}) < 8);
      CHECK(c.group_m2 >= static_cast<double>(c.cells.size()) * 0.04 - 1e-9);
    }
    std::sort(all.begin(), all.end());
    std::sort(clustered.begin(), clustered.end());
    CHECK(all == clustered);
    // The size of every group against a flood of our own.
    std::vector<bool> done(all.size(), false);
    std::vector<double> groups, told;
    for (std::size_t seed = 0; seed < all.size(); ++seed) {
      if (done[seed]) continue;
      std::vector<std::size_t> queue{seed};
      done[seed] = true;
      for (std::size_t head = 0; head < queue.size(); ++head) {
        for (std::size_t i = 0; i < all.size(); ++i) {
          const VoxelKey a = all[queue[head]], b = all[i];
          if (done[i] ||
              std::max({std::abs(a.x - b.x), std::abs(a.y - b.y), std::abs(a.z - b.z)}) > 1)
            continue;
          done[i] = true;
          queue.push_back(i);
        }
      }
      groups.insert(groups.end(), queue.size(), static_cast<double>(queue.size()) * 0.04);
    }
    for (const CellCluster& c : cells.frontier().clusters())
      told.insert(told.end(), c.cells.size(), c.group_m2);
    std::sort(groups.begin(), groups.end());
    std::sort(told.begin(), told.end());
    REQUIRE(groups.size() == told.size());
    for (std::size_t i = 0; i < groups.size(); ++i) REQUIRE(groups[i] == Approx(told[i]));
  }
}

TEST_CASE(
    "a surface looked at often enough is no longer owed, also when noise moves it by a voxel") {
  VoxelMap m(toy::config());
  toy::see(m, kRoom, {{0, -1, 1.5}, 0});
  RegionCells cells(m, kTurned, 2, 2.5);
  cells.update();
  const VoxelKey wall = m.key({3.1, -0.9, 1.5});
  const auto is_owed = [&](VoxelKey k) {
    return bit(marks_of(cells.owed(), cells, block_of(k)), local_index(k));
  };
  REQUIRE(is_owed(wall));
  cells.count_look(wall, cells.open_faces(wall));
  cells.settle();
  CHECK(is_owed(wall));
  cells.count_look(wall, cells.open_faces(wall));
  cells.settle();
  CHECK_FALSE(is_owed(wall));
  CHECK_FALSE(is_owed({wall.x - 1, wall.y, wall.z}));
}

namespace {

/// Lays a sheet one voxel thick into free space: at height(x, y), in voxels.
void lay_sheet(VoxelMap& m, auto height) {
  std::vector<Voxel> voxels(kBlockVoxels, Voxel::kFree);
  for (int x = 0; x < kBlockSide; ++x) {
    for (int y = 0; y < kBlockSide; ++y) {
      const VoxelKey k{x, y, height(x, y)};
      voxels[static_cast<std::size_t>(local_index(k))] = Voxel::kOccupied;
    }
  }
  m.merge(RobotId{3}, {0, 0, 0}, encode_block(voxels));
}
const Box kSheetBox = Box::from_corners({0, 0, 0}, {3.2, 3.2, 3.2});

}  // namespace

TEST_CASE("a thin sheet is owed looks on each of its sides") {
  VoxelMap m(toy::config());
  lay_sheet(m, [](int, int) { return 9; });
  RegionCells cells(m, kSheetBox, 2, 2.5);
  cells.update();
  const VoxelKey k{7, 7, 9};
  constexpr FaceSet kUp = 1u << 4, kDown = 1u << 5;
  REQUIRE(cells.owed_faces(k) == (kUp | kDown));
  CHECK(cells.hidden(k) == Approx(2));
  for (int look = 0; look < 2; ++look) cells.count_look(k, kUp);
  cells.settle();
  CHECK(cells.owed_faces(k) == kDown);
  CHECK(cells.hidden(k) == Approx(1));

  // What is seen from above is not seen from below.
  const Aim aim = surface_aim(cells, k);
  CHECK(faces_sighted(m, aim, m.center({2, 7, 13}), 4.5) == 0);
  CHECK(faces_sighted(m, aim, m.center({2, 7, 5}), 4.5) == kDown);
}

TEST_CASE("a slope is seen with whichever of its faces is in sight") {
  VoxelMap m(toy::config());
  lay_sheet(m, [](int x, int) { return 12 - x / 2; });
  RegionCells cells(m, kSheetBox, 2, 2.5);
  cells.update();
  // The edge of a step: open above and ahead; what looks from behind and above sees the slope.
  const VoxelKey k{7, 7, 9};
  REQUIRE((cells.owed_faces(k) & (1u << 0 | 1u << 4)) == (1u << 0 | 1u << 4));
  const FaceSet seen = faces_sighted(m, surface_aim(cells, k), m.center({5, 7, 14}), 4.5);
  CHECK((seen & 1u << 0) != 0);
  CHECK((seen & 1u << 4) != 0);
}

TEST_CASE("level surfaces that nobody can inspect are not owed looks, slopes are") {
  const LeastTilt least{0.07, 0.07};
  const auto owed_above = [&](auto height) {
    VoxelMap m(toy::config());
    lay_sheet(m, height);
    RegionCells cells(m, kSheetBox, 2, 2.5, least);
    cells.update();
    int n = 0;
    for (int x = 4; x < 12; ++x) {
      for (int y = 4; y < 12; ++y) {
        for (int z = 5; z < 16; ++z) n += (cells.owed_faces({x, y, z}) & 1u << 4) != 0;
      }
    }
    return n;
  };
  CHECK(owed_above([](int, int) { return 9; }) == 0);
  // Noise moves single voxels.
  CHECK(owed_above([](int x, int y) { return 9 + (x * 7 + y * 11) % 13 / 12; }) == 0);
  CHECK(owed_above([](int x, int) { return 12 - x / 4; }) == 64);           // 14°
  CHECK(owed_above([](int x, int) { return 12 - std::abs(x - 8); }) > 50);  // a ridge
}

TEST_CASE("a frontier looked at in vain is given up") {
  VoxelMap m(toy::config());
  toy::see(m, kRoom, {{0, -1, 1.5}, 0});
  RegionCells cells(m, kTurned, 0, 2.5);
  cells.update();
  std::vector<VoxelKey> before, after;
  cells.near(cells.frontier(), Vec3::Zero(), 100, [&](VoxelKey k) { before.push_back(k); });
  for (int i = 0; i < 3; ++i) cells.looked_in_vain(before[5]);
  cells.settle();
  cells.near(cells.frontier(), Vec3::Zero(), 100, [&](VoxelKey k) { after.push_back(k); });
  before.erase(before.begin() + 5);
  CHECK(before == after);
}

TEST_CASE("the normal of a seen wall points at the viewer") {
  VoxelMap m(toy::config());
  const Vec3 eye(0, -1, 1.5);
  Random random(4, RobotId{1}, "normal");
  for (int i = 0; i < 3; ++i) toy::see(m, kRoom, {eye, 0}, toy::Sensor::noisy(), 0.5 * i, &random);
  CHECK(surface_normal(m, {3.1, -0.9, 1.5}, eye).dot(Vec3(-1, 0, 0)) > 0.9);
  toy::see(m, kRoom, {eye, 3.1});
  CHECK(surface_normal(m, {-3.5, -1, 0}, eye).dot(Vec3(0, 0, 1)) > 0.8);
  CHECK(surface_normal(m, {6, -1, 1.5}, eye).isZero());
}
