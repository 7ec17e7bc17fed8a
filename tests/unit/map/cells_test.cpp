#include <catch2/catch.hpp>
#include <functional>

#include "common/map/region_cells.h"
#include "common/map/targets.h"
#include "common/map/visibility.h"
#include "tests/unit/map/said.h"
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
    if (round == 3) m.merge(RobotId{3}, said({0, 0, 0}, Voxel::kFree));
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
  const FaceSet faces = cells.owed_faces(wall);
  REQUIRE(faces != 0);
  cells.count_look(wall, faces, {0, -1, 1.5});
  cells.settle();
  CHECK(is_owed(wall));
  cells.count_look(wall, faces, {0, -1, 1.5});
  cells.settle();
  CHECK_FALSE(is_owed(wall));
  CHECK_FALSE(is_owed({wall.x - 1, wall.y, wall.z}));
}

namespace {

/// A map in which every voxel around the origin is known, as somebody else would tell it.
void make_known(VoxelMap& m, const std::function<bool(const Vec3&)>& solid) {
  for (int b = 0; b < 4 * 4 * 3; ++b) {
    const BlockKey key{b % 4 - 2, b / 4 % 4 - 2, b / 16 - 1};
    std::vector<Voxel> voxels;
    voxels.reserve(kBlockVoxels);
    for (int i = 0; i < kBlockVoxels; ++i)
      voxels.push_back(solid(m.center(voxel_in(key, i))) ? Voxel::kOccupied : Voxel::kFree);
    m.merge(RobotId{3}, said(key, voxels));
  }
}

/// Looks that show `faces`, from `eye`, until they are enough.
void look_often(RegionCells& cells, VoxelKey k, FaceSet faces, const Vec3& eye) {
  for (int i = 0; i < 2; ++i) cells.count_look(k, faces, eye);
  cells.settle();
}

constexpr FaceSet kTop = 16, kBottom = 32, kSouth = 8;
const Box kBox = Box::from_corners({-3, -3, 0.5}, {3, 3, 3.5});

/// A wall from y = 0 on, and a roof that reaches out over it.
struct Overhang {
  VoxelMap m{toy::config()};
  RegionCells cells{m, kBox, 2, 2.5};
  const VoxelKey under = m.key({0.1, 0.1, 1.9});  ///< of the wall, next to the roof

  Overhang() {
    make_known(m, [](const Vec3& p) { return p.y() > 0 || (p.y() > -1 && p.z() > 2); });
    cells.update();
  }
};

}  // namespace

TEST_CASE(
    "looks from above leave the side of a roof owed, but not the steps that noise made in it") {
  // A slab from y = 0 on, and one voxel upon it.
  const auto solid = [](const Vec3& p) {
    const bool step = p.x() > 1 && p.x() < 1.2 && p.y() > 1 && p.y() < 1.2 && p.z() < 2.2;
    return (p.y() > 0 && p.z() > 1 && p.z() < 2) || (step && p.z() > 1);
  };
  VoxelMap m(toy::config());
  make_known(m, solid);
  RegionCells cells(m, kBox, 2, 2.5);
  cells.update();
  const VoxelKey edge = m.key({0.1, 0.1, 1.9}), step = m.key({1.1, 1.1, 2.1});
  REQUIRE(cells.promise(edge) == 1);
  REQUIRE(cells.promise(step) == 1);
  look_often(cells, edge, kTop, {0, 0.1, 4});
  look_often(cells, step, kTop, {1, 1, 4});
  CHECK(cells.owed_faces(edge) == kSouth);
  CHECK(cells.promise(edge) > 0);
  CHECK(cells.promise(edge) < 0.5);
  CHECK(cells.promise_from(edge, {0.1, -3, 1.9}) == cells.promise(edge));
  CHECK(cells.promise_from(edge, {0.1, 3, 1.9}) == 0);
  CHECK(cells.promise(step) == 0);
  CHECK(cells.owed_faces(step) == 0);
}

TEST_CASE("the looks at the upper side of a thin roof say nothing of its underside") {
  VoxelMap m(toy::config());
  make_known(m, [](const Vec3& p) { return p.z() > 2 && p.z() < 2.4; });
  RegionCells cells(m, kBox, 2, 2.5);
  cells.update();
  const VoxelKey below = m.key({0.1, 0.1, 2.1}), above = m.key({0.1, 0.1, 2.3});
  REQUIRE(cells.owed_faces(below) == kBottom);
  look_often(cells, above, kTop, {0, 0, 4});
  CHECK(cells.owed_faces(above) == 0);
  CHECK(cells.owed_faces(below) == kBottom);
}

TEST_CASE_METHOD(Overhang, "the side below an overhang is owed looks from several sectors") {
  const VoxelKey open = m.key({0.1, 0.1, 1.1});
  const Vec3 p = m.center(under);
  for (const VoxelKey& k : {under, open}) look_often(cells, k, kSouth, p + Vec3(-0.5, -2, -0.5));
  CHECK(cells.promise(open) == 0);
  const double at_first = cells.promise(under);
  CHECK(at_first > 0);
  // Once more from there shows the same.
  CHECK(cells.promise_from(under, p + Vec3(-0.6, -2, -0.5)) == 0);
  CHECK(cells.promise_from(under, p + Vec3(0.6, -2, -0.5)) == at_first);
  look_often(cells, under, kSouth, p + Vec3(0.6, -2, -0.5));
  CHECK(cells.promise(under) < at_first);
  look_often(cells, under, kSouth, p + Vec3(2, -0.6, -0.5));
  CHECK(cells.promise(under) == 0);
}

TEST_CASE_METHOD(
    Overhang, "a look at the side below an overhang counts when it shows the corner between them") {
  const VoxelKey open = m.key({0.1, 0.1, 1.3});
  CHECK(cells.overhung(under, 3));
  CHECK_FALSE(cells.overhung(open, 3));
  // From just above the overhang's underside its edge hides the corner.
  const Vec3 higher(0.1, -2.8, 2.12), lower(0.1, -2.8, 1.5);
  REQUIRE(m.line_of_sight(higher, m.center(under) - Vec3(0, 0.11, 0), false));
  CHECK(faces_sighted(m, surface_aim(m, cells, under), higher, 5) == 0);
  CHECK(faces_sighted(m, surface_aim(m, cells, under), lower, 5) == kSouth);
  CHECK(cells.promise_from(under, m.center(under) + Vec3(0, -2, 0.5)) == 0);
  CHECK(cells.promise_from(under, m.center(under) + Vec3(0, -2, -0.5)) == cells.promise(under));
}

TEST_CASE_METHOD(
    Overhang,
    "nooks promise nothing when they are not asked for, and what they did when they are") {
  cells.ask_for_nooks(false);
  CHECK(cells.promise(under) == 1);  // nobody has looked at it
  look_often(cells, under, kSouth, m.center(under) + Vec3(-0.5, -2, -0.5));
  CHECK(cells.promise(under) == 0);
  cells.ask_for_nooks(true);
  CHECK(cells.promise(under) > 0);
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
